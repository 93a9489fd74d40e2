# `make run` and `make test` set up all they need in .venv; nothing is installed outside it.

PYTHON ?= python3
BIN := .venv/bin

.PHONY: run demo test coverage lint bench clean

.venv/ready: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "sar-tui needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || { echo "Python cannot make a virtual environment; on Debian and Ubuntu: sudo apt install python3-venv"; exit 1; }
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

run: .venv/ready  ## the app, with its data in data/
	@SAR_TUI_DATA=$${SAR_TUI_DATA:-data} $(BIN)/sar-tui

demo: .venv/ready  ## a session by a simulated participant; needs no terminal
	@folder=$$(mktemp -d) && $(BIN)/sar-tui simulate keyboard --user average --seed 1 --data $$folder && $(BIN)/sar-tui show last --data $$folder; status=$$?; rm -rf "$$folder"; exit $$status

test: .venv/ready  ## every test, on two cores
	@$(BIN)/python -m pytest -n 2 --dist loadgroup

coverage: .venv/ready  ## the same, and what of the code they run; it takes a third longer
	@$(BIN)/python -m pytest -n 2 --dist loadgroup --cov --cov-report=term

lint: .venv/ready  ## style, types, floors
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports

bench: .venv/ready  ## timing, start-up and scale, into benchmarks/results/
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv build dist
