# Two targets do everything on a machine with Python 3.11 to 3.13:
#   make demo   diagnose the bundled example campaign, write its report
#   make test   run the whole suite
# More: make docs, its pages in out/docs; make bench, the table of speed; make
# wheel, which builds the wheel and uses it apart from the source.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
EXAMPLE := tests/data/example
OUT := out/demo
# What builds the package is pinned as what it needs. Modules are compiled when
# first used, which few of those installed are, and are then kept.
unexport PYTHONDONTWRITEBYTECODE
PINNED := -c constraints.txt --build-constraint constraints.txt

.PHONY: demo test lint types docs bench wheel clean

demo: $(STAMP)
	$(BIN)/brace-drake diagnose $(EXAMPLE) --out $(OUT)

# What does not need the tests runs beside them.
test: $(STAMP)
	$(BIN)/python tools/run_tests.py --also "$(BIN)/python -m mypy" \
	  --also "$(BIN)/ruff check ." --also "$(BIN)/ruff format --check ."

lint: types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/python -m mypy

docs: $(STAMP)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/docs

wheel: $(STAMP)
	$(BIN)/python tools/smoke_wheel.py --demo --packages \
	  "$$($(BIN)/python -c 'import site; print(site.getsitepackages()[0])')"

bench: $(STAMP)
	$(BIN)/python tools/bench.py

$(STAMP): pyproject.toml constraints.txt tools/check_machine.py
	$(PYTHON) tools/check_machine.py
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip -c constraints.txt
	$(BIN)/python -m pip install --quiet --no-compile -e ".[dev]" $(PINNED)
	touch $@

clean:
	rm -rf $(VENV) out docs/reference
