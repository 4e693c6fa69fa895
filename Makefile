# Two commands: `make demo` and `make test`. Each sets up what it needs, once, in .venv.

SHELL := /bin/bash
# A sourced ROS 2 install must not mix with the wheels in .venv.
unexport PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH
# pip leaves bytecode to the first import (below): whoever forbids that waits for it in every process.
unexport PYTHONDONTWRITEBYTECODE

VENV := $(CURDIR)/.venv
BIN := $(VENV)/bin
SEED := 25
PACKAGES := package.xml setup.py setup.cfg tissue_probe/__init__.py $(wildcard config/* launch/* examples/*.csv examples/*.mcap) \
	$(shell find msg_defs crtk_msgs -type f)

# Tests in which processes live in real time: apart from those that need the whole processor, and in
# two runs, since their folders' conftest.py have one name.
LIVE := test/nodes test/launch test/benchmarks
# Tests in a browser, which take minutes: `make test-page` runs them.
PAGE := test/workbench/test_workbench_page.py test/workbench/test_one_answer.py test/workbench/test_study_page.py
# Tests of the site of documents, which `make docs` builds.
SITE := test/site
# Tests of many seeds or many cases of a kind, of which `make test` runs some: `make test-slow` runs them.
SLOW := battery
SIDE_BY_SIDE := --numprocesses 2 --dist
NODES_SIDE_BY_SIDE := --numprocesses 3 --dist
# A machine that others use too may hold up a process for seconds. A live test that failed is therefore run
# once more, alone; both runs are in the log. $(1): options of the
# first run alone, $(2): options and folders.
live = $(BIN)/python -m pytest $(1) $(2) || \
	$(BIN)/python -m pytest --last-failed --last-failed-no-failures none $(2)
# Two workers on two cores: threads of each would only wait for those of the other. Tests of nodes wait
# for processes for much of their time: of these a third.
test test-slow: export OPENBLAS_NUM_THREADS := 1

.PHONY: demo hidden-effect hidden-effect-live test test-slow test-page docs lint lint-page benchmark setup clean help

help: ## List the targets.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

demo: $(VENV)/packages.done ## Palpate a simulated phantom; leaves run.mcap, map.png, estimates.png.
	$(BIN)/tissue_probe demo

test: $(VENV)/packages.done $(VENV)/development.done ## Run the tests, real ROS 2 processes included.
	$(BIN)/python test/kernels.py
	$(BIN)/python -m pytest $(SIDE_BY_SIDE) loadfile -m "not $(SLOW)" $(addprefix --ignore=,$(LIVE) $(PAGE) $(SITE))
	$(call live,$(NODES_SIDE_BY_SIDE) loadfile -m "not crowded",--timeout-method thread test/nodes)
	$(call live,-m crowded,--timeout-method thread test/nodes)
	$(call live,$(SIDE_BY_SIDE) loadfile,test/launch test/benchmarks)

test-slow: $(VENV)/packages.done $(VENV)/development.done ## Run the tests of many seeds that `make test` leaves out.
	$(BIN)/python -m pytest $(SIDE_BY_SIDE) loadfile -m $(SLOW) $(addprefix --ignore=,$(LIVE) $(PAGE) $(SITE))

test-page: $(VENV)/packages.done $(VENV)/development.done ## Test the workbench's page in Chromium.
	@if command -v chromium >/dev/null; then $(BIN)/python test/kernels.py && { $(call live,,$(PAGE)); }; \
		else echo "The page is not tested: there is no chromium (apt-get install chromium)."; fi

docs: export OPENBLAS_NUM_THREADS := 1
docs: $(VENV)/packages.done $(VENV)/docs.done ## Build the site of documents into build/docs/html; runs the notebooks.
	$(BIN)/python docs/site build/docs
	$(BIN)/python -m pytest --quiet $(SITE)

hidden-effect: $(VENV)/packages.done ## Hide two effects in a recording and find them; leaves hidden-effect/.
	rm -rf hidden-effect
	$(BIN)/tissue_probe challenge make --count 1 --hide two --seed $(SEED) --rig tolerant \
		--excitation chirp60 --answers hidden-effect/answers.sealed.json hidden-effect/recordings
	cd hidden-effect && $(BIN)/tissue_probe compare recordings/0001.csv --rig compliant_probe --starts at-rest
	cd hidden-effect && $(BIN)/tissue_probe diagnose recordings/0001.csv --rig compliant_probe --starts at-rest \
		--validate recordings/0001_second.csv --json 0001.json
	cd hidden-effect && $(BIN)/tissue_probe improve recordings/0001.csv --rig compliant_probe --starts at-rest \
		--validate recordings/0001_second.csv --output answer
	@echo "The seal is opened:"
	cd hidden-effect && $(BIN)/tissue_probe challenge open 0001 --model answer/model.yaml

hidden-effect-live: $(VENV)/packages.done ## Find a hidden effect while the suite runs; leaves hidden-effect-live/.
	rm -rf hidden-effect-live
	$(BIN)/python examples/hidden_effect_live.py --folder hidden-effect-live

lint: $(VENV)/packages.done $(VENV)/development.done ## Check style, docstrings, import contracts, types.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy
	@if $(MAKE) --silent node_modules/.done; then $(MAKE) --no-print-directory lint-page; \
		else echo "The scripts of the page are not checked: npm's registry cannot be reached."; fi

lint-page: node_modules/.done ## Check the scripts of the workbench's page: types, style.
	PATH=$(BIN):$$PATH node_modules/.bin/tsc -p tissue_probe/workbench/page/jsconfig.json
	PATH=$(BIN):$$PATH node_modules/.bin/eslint tissue_probe/workbench/page

benchmark: $(VENV)/packages.done $(VENV)/development.done ## Measure speed, latency and losses.
	$(BIN)/python -m benchmarks

setup: $(VENV)/packages.done ## Only set up; afterwards .venv/bin/tissue_probe works from any folder.

clean: ## Remove everything that setup made.
	rm -rf .venv build node_modules

# Bytecode is left to the first import: most modules of what is installed are never imported. The pip
# that comes with Python 3.11 takes twice as long as today's.
$(VENV)/wheels.done: requirements/python.txt requirements/daq.txt requirements/workbench.txt requirements/study.txt \
		requirements/ros-jazzy-wheels.txt
	@command -v c++ >/dev/null && python3 -c "import sysconfig, pathlib, sys, venv, ensurepip; \
		sys.exit(not pathlib.Path(sysconfig.get_paths()['include'], 'Python.h').exists())" || \
		{ echo "A C++ compiler, Python's headers or its venv are missing: on Debian," \
		"apt-get install g++ python3-dev python3-venv"; exit 1; }
	test -x $(BIN)/python || python3 -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/pip install --quiet --disable-pip-version-check --no-compile $(addprefix -r ,$^)
	touch $@

$(VENV)/development.done: requirements/development.txt $(VENV)/wheels.done
	$(BIN)/pip install --quiet --disable-pip-version-check --no-compile -r $<
	touch $@

$(VENV)/docs.done: requirements/docs.txt $(VENV)/development.done
	$(BIN)/pip install --quiet --disable-pip-version-check --no-compile -r $<
	touch $@

# The linters of the page's scripts, by the Node.js that PyPI has; the page itself needs neither.
node_modules/.done: package.json package-lock.json $(VENV)/development.done
	PATH=$(BIN):$$PATH $(BIN)/npm ci --no-audit --no-fund --loglevel=error
	touch $@

# All packages go into .venv itself, so that nothing needs to be sourced afterwards. The Python
# package is linked, not copied: an edit takes effect at once. Where the link lies colcon tells
# only its own setup scripts; the .pth file tells the interpreter.
$(VENV)/packages.done: $(VENV)/wheels.done $(PACKAGES)
	AMENT_PREFIX_PATH=$(VENV) CMAKE_PREFIX_PATH=$(VENV) PATH=$(BIN):$$PATH \
	$(BIN)/colcon --log-base build/log build --base-paths . msg_defs crtk_msgs --symlink-install \
		--build-base build --install-base $(VENV) --merge-install \
		--cmake-args -DPython3_EXECUTABLE=$(BIN)/python3 -DBUILD_TESTING=OFF
	$(BIN)/python -c "import site; print(site.getsitepackages()[0])" | \
		xargs -I {} sh -c 'echo $(CURDIR)/build/tissue_probe > {}/tissue_probe.pth'
	ln -sf ../lib/tissue_probe/tissue_probe $(BIN)/tissue_probe
	touch $@
