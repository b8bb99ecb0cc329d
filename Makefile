# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow fuzz kills ui-test soak ui-pictures lint extension package install-test wheel-test matrix docs library bench bench-solver pictures paper thumbnails environment lock latest clean

VENV ?= .venv
# The Pythons that may be used, in order of preference; those that Blender has a module for where it is empty.
VERSIONS ?=
# The Python that the environment is made with, where it is not to be looked for.
PYTHON ?=
# The Blenders that are tested as modules, and the Python that each has a wheel for.
BLENDERS ?= 4.5.15 5.0.1 5.2.3
python_of = $(if $(filter 4.% 5.0.%,$(1)),3.11,3.13)
each_python = $(addprefix $(1),$(sort $(foreach b,$(BLENDERS),$(call python_of,$(b)))))
# Where the real meshes lie (spot, fertility, stanford-bunny ... from public collections); tests do without.
MESHES ?= ../shared/meshes

# Any Python starts the scripts that look for the right one and make the environment.
starters = $(if $(PYTHON),"$(PYTHON)") python3 $(VERSIONS:%=python%) python3.13 python3.11 python
find_start = $(shell for p in $(starters); do "$$p" -c 'import argparse' 2>/dev/null && echo "$$p" && break; done)
start = "$(or $(find_start),$(error no Python found: install Python 3.13 or name it with PYTHON=path))"
settings = --venv "$(VENV)" $(if $(VERSIONS),--versions "$(VERSIONS)") $(if $(PYTHON),--python "$(PYTHON)")
make = $(start) tools/make.py

python = $(VENV)/bin/python
# The code that runs is this checkout's, whichever one the environment was made for: tools/requirements.py makes the link.
export PYTHONPATH := $(CURDIR)/out/tree

help:
	@echo 'make demo         stripes on a sample mesh: out/demo.blend, out/demo.png, out/demo.json'
	@echo 'make test         the tests, in some minutes: a process for each core'
	@echo 'make test-slow    the other tests'
	@echo 'make fuzz         meshes, settings, texts, files and faults at random; MINUTES=60 SEED=0'
	@echo 'make kills        commands and batches that are killed at random moments; KILLS=200 SEED=0'
	@echo 'make ui-test      a real Blender window, driven, in English and in German; SYNCH_BLENDER=command starts a Blender, Xvfb has to be there'
	@echo 'make soak         everyday actions at random in that window, without an error on its console; MINUTES=60 SEED=0'
	@echo 'make ui-pictures  the same, and its pictures into docs/'
	@echo 'make lint         ruff (rules and format) and mypy'
	@echo 'make extension    the zip for Blender in out/; WHEELS=1 bundles SciPy, one zip for each platform'
	@echo 'make package      all of a release in out/package: zips of all platforms, a repository of extensions, the package of Python'
	@echo 'make install-test the release into fresh Blenders: enable, use, disable, uninstall; SYNCH_BLENDER=command for a real one'
	@echo 'make wheel-test   the package of Python, in a fresh environment of each Python: examples, Python of README and manual'
	@echo 'make matrix       all tests on each Blender: $(BLENDERS); deprecation warnings are failures'
	@echo 'make docs         the manual as a site in out/site, by MkDocs in an environment of its own; strict: a dead link is an error'
	@echo 'make library      the library of assets that the extension ships; needs Blender 4.5: VENV=.venv-3.11'
	@echo 'make bench        bounds and energies of three meshes beside other methods; MESHES=folder holds them'
	@echo 'make bench-solver times, bounds and energies of six meshes beside other methods, and time against size'
	@echo 'make pictures     the pictures of the README and of docs/; MESHES=folder holds the meshes'
	@echo 'make paper        what is missing of the paper reproduced, docs/paper, in about an hour; MESHES=folder holds the meshes'
	@echo 'make thumbnails   those that the extension ships'
	@echo 'make environment  $(VENV) with Blender as a Python module; the other targets make it on demand'
	@echo 'make latest       the tests with the newest versions of all that is installed, on each Python'
	@echo 'make lock         requirements/: the versions that environments get, from the newest that work together'
	@echo 'make clean        remove outputs and caches, keep the environment'
	@echo 'Settings: PYTHON=path/to/python3.13, VENV=folder'

demo test-slow lint environment:
	@$(make) $@ $(settings) $(BPY:%=--blender %)

# Runs on several Blenders may share what is the same on all: SHARE=1/2 and SHARE=2/2.
SHARE ?= 1/1

test:
	@$(make) $@ $(settings) $(BPY:%=--blender %) --share $(SHARE)

MINUTES ?= 10
SEED ?= 0

fuzz: environment
	$(python) tools/fuzz.py $(MINUTES) $(SEED)

KILLS ?= 200

kills: environment
	$(python) tools/kills.py $(KILLS) $(SEED)

# In English, then in German with translated names of new data.
ui-test: environment
	$(python) -m pytest -rs tests/ui --ignore tests/ui/test_soak.py
	SYNCH_LANGUAGE=de_DE $(python) -m pytest -rs tests/ui --ignore tests/ui/test_soak.py --ignore tests/ui/test_languages.py

soak: environment
	SYNCH_SOAK=$(MINUTES) SYNCH_SEED=$(SEED) $(python) -m pytest -rs -s tests/ui/test_soak.py

ui-pictures: ui-test
	cp out/ui/simple.png out/ui/panel.png out/ui/progress.png out/ui/strokes.png out/ui/click_2.png out/ui/click_3.png out/ui/click_4.png docs/

# Written from environments with the newest versions, to be tested before they are committed.
lock: $(call each_python,lock-)

lock-%:
	rm -rf out/lock-$*
	$(start) tools/environment.py --venv out/lock-$* --versions $* --latest blender batch flows test docs lint package
	out/lock-$*/bin/python tools/requirements.py --lock
	rm -rf out/lock-$*

latest: $(call each_python,latest-)

latest-%:
	$(make) test --venv .venv-latest-$* --versions $* --latest

extension:
	@$(make) $@ $(settings) $(if $(WHEELS),--wheels)

package: environment
	$(python) tools/package.py
	SYNCH_ARCHIVES=out/package/extensions $(python) -m pytest -q tests/addon/test_rules.py

install-test: package $(BLENDERS:%=install-test-%)
	$(if $(SYNCH_BLENDER),$(python) tools/install_test.py out/package/extensions $(SYNCH_BLENDER))

# Nothing but Blender is in these environments.
install-test-%:
	rm -rf out/blender-$*
	$(start) tools/environment.py --venv out/blender-$* --versions $(call python_of,$*) --only bpy==$*
	out/blender-$*/bin/python tools/install_test.py out/package/extensions
	rm -rf out/blender-$*

# In one process, since the start takes as long as most of them.
run_examples = 'import glob, runpy; [runpy.run_path(path, run_name="__main__") for path in sorted(glob.glob("examples/[a-z]*.py"))]'
print_packages = -c 'import sysconfig; print(sysconfig.get_path("purelib"))'

# The package of Python as a user has it: nothing of the checkout is on the path. What it depends on is that of the tests'
# environment: its folder comes last, and .pth files in it, that of the checkout too, are not read.
wheel-test: $(call each_python,wheel-test-)

wheel-test-%: export PYTHONPATH :=
wheel-test-%:
	rm -rf out/wheel-$*
	@$(start) tools/make.py environment --venv .venv-$* --versions $*
	.venv-$*/bin/python -m venv --without-pip out/wheel-$*
	.venv-$*/bin/python tools/package.py --python --output-dir out/wheel-$*/made
	.venv-$*/bin/python -m twine check --strict out/wheel-$*/made/synch_fields-*
	.venv-$*/bin/python -m pip --python out/wheel-$*/bin/python install --quiet --no-deps --no-index out/wheel-$*/made/*.whl
	.venv-$*/bin/python $(print_packages) >"$$(out/wheel-$*/bin/python $(print_packages))/dependencies.pth"
	out/wheel-$*/bin/python -I -c $(run_examples)
	out/wheel-$*/bin/python -m pytest -q tests/addon/test_readme.py -k test_python_runs
	rm -rf out/wheel-$*

matrix: $(BLENDERS:%=matrix-%)

matrix-%: export PYTEST_ADDOPTS := -W error::DeprecationWarning -W error::PendingDeprecationWarning
matrix-%:
	$(MAKE) test test-slow VENV=.venv-blender-$* BPY=$* VERSIONS=$(call python_of,$*)

docs:
	@$(start) tools/environment.py --venv .venv-docs --only docs
	NO_MKDOCS_2_WARNING=1 .venv-docs/bin/python -m mkdocs build --strict

library: environment
	$(python) tools/assets.py

bench: environment
	$(python) bench/bounds.py $(MESHES)/spot.obj $(MESHES)/fertility.obj $(MESHES)/stanford-bunny.obj

bench_meshes = spot fandisk rocker-arm fertility stanford-bunny botijo

bench-solver: environment
	$(python) bench/solver.py $(bench_meshes:%=$(MESHES)/%.obj)
	$(python) bench/scaling.py $(MESHES)/stanford-bunny.obj=1,2,4,5 $(MESHES)/spot.obj=1,2,4,8,18 sphere=10,32,316 grid=32,48,64,96,128

pictures: demo
	cp out/demo.png docs/suzanne.png
	$(python) -m synch_fields stripes $(MESHES)/spot.obj --view 205 12 --render docs/spot.png
	$(python) -m synch_fields stripes $(MESHES)/stanford-bunny.obj --view -20 12 --render docs/bunny.png
	$(python) docs/make/gallery.py $(MESHES) --folder docs
	$(python) docs/make/quads.py $(MESHES) --folder docs
	$(python) docs/make/bake.py $(MESHES) --folder docs
	$(python) docs/make/constraints.py $(MESHES) --folder docs
	$(python) docs/make/vortices.py --folder docs
	$(python) docs/make/printing.py $(MESHES) --folder docs
	$(python) docs/make/animation.py --folder docs
	$(python) docs/make/front.py $(MESHES) --folder docs
	$(python) docs/make/moving.py $(MESHES) --folder docs

paper: environment
	$(python) docs/make/paper.py $(MESHES)

thumbnails: environment
	$(python) tools/thumbnails.py

clean:
	rm -rf out build *.egg-info .pytest_cache .ruff_cache .mypy_cache
	find core synch_addon tests bench docs tools -name __pycache__ -prune -exec rm -rf {} +
	rm -rf __pycache__
