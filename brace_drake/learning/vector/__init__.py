"""Many episodes of learning at once, for gymnasium.

`copies` are closed loops that go four by four through compiled code, `env` the
vector env on them, `steps` what a step of all of them comes to.
"""
