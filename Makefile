# Everything begins here. Python 3.11 or newer and pip are all that is needed.
PYTHON ?= python3
BIN := .venv/bin
# other systems' linkers lack gcc's sanitizers, and gcc leaves a file at Ctrl-C
NOT_SANITIZED := --ignore tests/conformance/test_platforms.py \
    --ignore tests/cosim/test_interrupt.py
SPREAD := --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

.DEFAULT_GOAL := help
.PHONY: help setup reproduce test quick thorough test-platforms check wheel docs rooms format notebooks sanitize bench clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' Makefile

setup: .venv/installed ## install stickslip into .venv

reproduce: .venv/installed ## reproduce the paper into results/paper
	$(BIN)/stickslip reproduce

test: .venv/tested ## run the tests, on all cores
	$(BIN)/python -m pytest $(SPREAD)

quick: .venv/tested ## run the quick tier of the tests, a minute on two cores
	$(BIN)/python -m pytest $(SPREAD) --quick

thorough: .venv/tested ## run the tests that learn many logs or run a drive hundreds of times
	$(BIN)/python -m pytest -m thorough

test-platforms: .venv/tested ## run FMUs of other platforms: needs qemu-user, libc6-arm64-cross, wine
	$(BIN)/python -m pytest -m platforms

check: .venv/checked ## lint, types and C format
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@mkdir -p .typed/stickslip # the packages as they are when installed
	@ln -sfn $(addprefix $(CURDIR)/,$(wildcard stickslip/*) cosim fmi fmucheck ga models) .typed/stickslip
	cd .typed && ../$(BIN)/mypy --config-file ../pyproject.toml
	$(BIN)/clang-format --dry-run --Werror $$(git ls-files '*.c' '*.h')

wheel: .venv/installed ## build the wheel into dist/, with all that it carries ready
	$(BIN)/python -m pip install --quiet --editable '.[compile,figures]'
	$(BIN)/python -m stickslip.precompile
	@rm -rf build # setuptools would carry what an earlier one contained
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .

docs: .venv/documented ## build the documentation into docs/_build, without a network
	$(BIN)/python -m sphinx -b html -W --keep-going -q -j auto -c docs . docs/_build/html

rooms: .venv/tested ## draw the rooms of stickslip/ and what each imports
	$(BIN)/python docs/rooms.py

format: .venv/checked ## format Python and C
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/clang-format -i $$(git ls-files '*.c' '*.h')

notebooks: .venv/tested ## execute the notebooks and store their outputs
	$(BIN)/python -m tests.stored_notebooks

sanitize: .venv/tested ## run the tests of the C, built by gcc with its sanitizers (Linux)
	STICKSLIP_CC=gcc STICKSLIP_CFLAGS="-O1 -fsanitize=address,undefined -fno-sanitize-recover=all -Wno-error" \
	    ASAN_OPTIONS=detect_leaks=0:handle_segv=0:handle_abort=0 STICKSLIP_CACHE="$$PWD/.sanitized" \
	    LD_PRELOAD="$$(gcc -print-file-name=libasan.so):$$(gcc -print-file-name=libubsan.so)" \
	    $(BIN)/python -m pytest $(SPREAD) $(NOT_SANITIZED) tests/models tests/conformance tests/cosim tests/ga

bench: .venv/tested ## measure speed, as ratios inside one run
	$(BIN)/python -m benchmarks

clean: ## remove the environment and all that git ignores
	git clean -fdXq

.venv/bin/python:
	$(PYTHON) -m venv --upgrade-deps .venv # an old pip takes half as long again

.venv/installed: pyproject.toml setup.py | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[compile]'
	touch $@

.venv/tested: pyproject.toml setup.py | .venv/bin/python
	$(BIN)/python -m pip install --quiet --no-compile --editable '.[test]' # what tests import is compiled then
	touch $@ .venv/installed

.venv/checked: pyproject.toml setup.py | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[check]'
	touch $@ .venv/installed

.venv/documented: pyproject.toml setup.py | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	touch $@ .venv/installed
