# `make run` sets up what the program needs in .venv, and `make test` what developers need besides; nothing is installed
# outside it.

PYTHON ?= python3
BIN := .venv/bin
comma := ,

# An environment for developers has all that the program needs, and is kept up to date as a whole.
PROGRAM := $(or $(wildcard .venv/ready),.venv/program)

.PHONY: run demo test test-all coverage lint bench clean

# $(call install,EXTRAS,HOW LONG)
define install
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "sar-tui needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@echo "Setting up .venv: this takes $(2), once."
	@echo "1/2 Making a virtual environment."
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || { echo "Python cannot make a virtual environment; on Debian and Ubuntu: sudo apt install python3-venv"; exit 1; }
	@echo "2/2 Installing sar-tui and the libraries it needs:"
	@{ $(BIN)/python -u -m pip install --disable-pip-version-check --progress-bar off --editable '.[$(1)]'; echo $$? > .venv/status; } | \
		awk '/^Collecting / { printf "%s ", $$2; fflush() } /^Installing collected/ { printf "\nAll downloaded; installing.\n"; fflush() }'
	@test "$$(cat .venv/status)" = 0 || { echo "The libraries could not be installed; see the reason above. Try again with: make $(MAKECMDGOALS)"; exit 1; }
	@$(BIN)/python -m compileall -q sar_tui tasks  # or the first start would
	@touch $@
endef

.venv/program: pyproject.toml
	$(call install,link$(comma)serve$(comma)letterbox,under a minute)

.venv/ready: pyproject.toml
	$(call install,dev,about two minutes)

run: $(PROGRAM)  ## the app, with its data in data/
	@SAR_TUI_DATA=$${SAR_TUI_DATA:-data} $(BIN)/sar-tui

demo: $(PROGRAM)  ## the app with invented people; nothing is kept
	@$(BIN)/sar-tui demo

# Three workers keep two cores busy: many tests wait for a program that they have started.
test: .venv/ready  ## every behaviour, in a few minutes on two cores
	@SAR_TUI_TEST_EXAMPLES=few $(BIN)/python -m pytest -n 3 --dist worksteal -m "not slow"

test-all: .venv/ready  ## every test, the long ones in full
	@$(BIN)/python -m pytest -n 2 --dist worksteal

coverage: .venv/ready  ## all tests, and which lines of the code they run
	@$(BIN)/python -m pytest -n 2 --dist worksteal --cov --cov-report=term

lint: .venv/ready  ## style, types, floors, translations
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports
	@$(BIN)/python -m tests.translations

bench: .venv/ready  ## timing, start-up and simulation, into benchmarks/results/
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv build dist
