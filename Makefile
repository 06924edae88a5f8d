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

PARTS := test_m-q test_d-k test_l test_t-z test_a-c test_r test_s

.PHONY: demo test test_link $(PARTS) lint types docs bench wheel clean

demo: $(STAMP)
	$(BIN)/brace-drake diagnose $(EXAMPLE) --out $(OUT)

# Two parts at a time, the longest first. Beside them those of the link, which
# keep real time: they mostly wait, and go before others.
test: lint
	$(MAKE) --no-print-directory test_link & link=$$!; \
	$(MAKE) --no-print-directory -k -j 2 $(PARTS); parts=$$?; \
	wait $$link && exit $$parts

test_link: FILES := test_link_*.py
test_a-c: FILES := test_[a-c]*.py
test_d-k: FILES := test_[d-k]*.py
test_l: FILES := test_l[!i]*.py
test_m-q: FILES := test_[m-q]*.py
test_r: FILES := test_r*.py
test_s: FILES := test_s*.py
test_t-z: FILES := test_[t-z]*.py
$(PARTS): SLOWER := nice -n 10

test_link $(PARTS): $(STAMP)
	OPENBLAS_NUM_THREADS=1 $(SLOWER) $(BIN)/python -m unittest discover \
	  -s tests -t . -b -p '$(FILES)'

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
