 Tests in which processes live.*# Two commands: `make demo` and `make test`. Each sets up what it needs, once, in .venv.
 Tests in which processes live.*
 Tests in which processes live.*SHELL := /bin/bash
 Tests in which processes live.*# A sourced ROS 2 install must not mix with the wheels in .venv.
 Tests in which processes live.*unexport PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH
 Tests in which processes live.*
 Tests in which processes live.*VENV := $(CURDIR)/.venv
 Tests in which processes live.*BIN := $(VENV)/bin
 Tests in which processes live.*SEED := 14
 Tests in which processes live.*PACKAGES := package.xml setup.py setup.cfg $(wildcard config/* launch/*) \
 Tests in which processes live.*	$(shell find msg_defs crtk_msgs -type f)
 Tests in which processes live.*
 Tests in which processes live.*# Tests in which processes live in real time: one after the other, so that none disturbs another.
 Tests in which processes live.*LIVE := test/nodes test/launch test/benchmarks
 Tests in which processes live.*
 Tests in which processes live.*.PHONY: demo hidden-effect test lint benchmark setup clean help
 Tests in which processes live.*
 Tests in which processes live.*help: ## List the targets.
 Tests in which processes live.*	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16
 Tests in which processes live.*
 Tests in which processes live.*demo: $(VENV)/packages.done ## Palpate a simulated phantom; leaves run.mcap, map.png, estimates.png.
 Tests in which processes live.*	$(BIN)/tissue_probe demo
 Tests in which processes live.*
 Tests in which processes live.*test: $(VENV)/packages.done $(VENV)/development.done ## Run all tests, real ROS 2 processes included.
 Tests in which processes live.*	$(BIN)/python -m pytest --numprocesses 2 --dist loadfile $(addprefix --ignore=,$(LIVE))
 Tests in which processes live.*	$(BIN)/python -m pytest $(LIVE)
 Tests in which processes live.*
 Tests in which processes live.*hidden-effect: $(VENV)/packages.done ## Hide two effects in a recording and find them; leaves hidden-effect/.
 Tests in which processes live.*	rm -rf hidden-effect
 Tests in which processes live.*	$(BIN)/tissue_probe challenge make --count 1 --hide two --seed $(SEED) --rig tolerant \
 Tests in which processes live.*		--excitation chirp60 --answers hidden-effect/answers.sealed.json hidden-effect/recordings
 Tests in which processes live.*	cd hidden-effect && $(BIN)/tissue_probe compare recordings/0001.csv --starts at-rest
 Tests in which processes live.*	cd hidden-effect && $(BIN)/tissue_probe diagnose recordings/0001.csv --starts at-rest \
 Tests in which processes live.*		--validate recordings/0001_second.csv --json 0001.json
 Tests in which processes live.*	cd hidden-effect && $(BIN)/tissue_probe improve recordings/0001.csv --starts at-rest \
 Tests in which processes live.*		--validate recordings/0001_second.csv --output answer
 Tests in which processes live.*	@echo "The seal is opened. Hidden were:"
 Tests in which processes live.*	@sed -n '/"effects": \[/,/\]/s/^ *"\([a-z_]*\)",*$$/- \1/p' hidden-effect/answers.sealed.json
 Tests in which processes live.*
 Tests in which processes live.*lint: $(VENV)/packages.done $(VENV)/development.done ## Check style, docstrings and import contracts.
 Tests in which processes live.*	$(BIN)/ruff check .
 Tests in which processes live.*	$(BIN)/ruff format --check .
 Tests in which processes live.*	$(BIN)/lint-imports
 Tests in which processes live.*
 Tests in which processes live.*benchmark: $(VENV)/packages.done $(VENV)/development.done ## Measure speed, latency and losses.
 Tests in which processes live.*	$(BIN)/python -m benchmarks
 Tests in which processes live.*
 Tests in which processes live.*setup: $(VENV)/packages.done ## Only set up; afterwards .venv/bin/tissue_probe works from any folder.
 Tests in which processes live.*
 Tests in which processes live.*clean: ## Remove everything that setup made.
 Tests in which processes live.*	rm -rf .venv build
 Tests in which processes live.*
 Tests in which processes live.*$(VENV)/wheels.done: requirements/python.txt requirements/ros-jazzy-wheels.txt
 Tests in which processes live.*	@command -v c++ >/dev/null && python3 -c "import sysconfig, pathlib, sys, venv, ensurepip; \
 Tests in which processes live.*		sys.exit(not pathlib.Path(sysconfig.get_paths()['include'], 'Python.h').exists())" || \
 Tests in which processes live.*		{ echo "A C++ compiler, Python's headers or its venv are missing: on Debian," \
 Tests in which processes live.*		"apt-get install g++ python3-dev python3-venv"; exit 1; }
 Tests in which processes live.*	test -x $(BIN)/python || python3 -m venv $(VENV)
 Tests in which processes live.*	$(BIN)/pip install --quiet --disable-pip-version-check $(addprefix -r ,$^)
 Tests in which processes live.*	touch $@
 Tests in which processes live.*
 Tests in which processes live.*$(VENV)/development.done: requirements/development.txt $(VENV)/wheels.done
 Tests in which processes live.*	$(BIN)/pip install --quiet --disable-pip-version-check -r $<
 Tests in which processes live.*	touch $@
 Tests in which processes live.*
 Tests in which processes live.*# All packages go into .venv itself, so that nothing needs to be sourced afterwards. The Python
 Tests in which processes live.*# package is linked, not copied: an edit takes effect at once. Where the link lies colcon tells
 Tests in which processes live.*# only its own setup scripts; the .pth file tells the interpreter.
 Tests in which processes live.*$(VENV)/packages.done: $(VENV)/wheels.done $(PACKAGES)
 Tests in which processes live.*	AMENT_PREFIX_PATH=$(VENV) CMAKE_PREFIX_PATH=$(VENV) PATH=$(BIN):$$PATH \
 Tests in which processes live.*	$(BIN)/colcon --log-base build/log build --base-paths . msg_defs crtk_msgs --symlink-install \
 Tests in which processes live.*		--build-base build --install-base $(VENV) --merge-install \
 Tests in which processes live.*		--cmake-args -DPython3_EXECUTABLE=$(BIN)/python3 -DBUILD_TESTING=OFF
 Tests in which processes live.*	$(BIN)/python -c "import site; print(site.getsitepackages()[0])" | \
 Tests in which processes live.*		xargs -I {} sh -c 'echo $(CURDIR)/build/tissue_probe > {}/tissue_probe.pth'
 Tests in which processes live.*	ln -sf ../lib/tissue_probe/tissue_probe $(BIN)/tissue_probe
 Tests in which processes live.*	touch $@
