# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow fuzz ui-test soak ui-pictures lint extension package install-test matrix docs library bench bench-solver pictures paper thumbnails environment clean

# The Pythons that a bpy wheel exists for, in order of preference.
VERSIONS ?= 3.13 3.11
VENV ?= .venv
# The Blenders that are tested as modules, and the Python that each has a wheel for.
BLENDERS ?= 4.5.15 5.0.1 5.2.3
python_of = $(if $(filter 4.% 5.0.%,$(1)),3.11,3.13)
# Where the real meshes lie (spot, fertility, stanford-bunny ... from public collections); tests do without.
MESHES ?= ../shared/meshes

# A candidate counts when it runs (a pyenv shim may exist and fail), is a wanted version and can make environments.
pyenv_folder = $(or $(PYENV_ROOT),$(HOME)/.pyenv)/versions
pyenv_pythons = $(foreach v,$(VERSIONS),$(wildcard $(pyenv_folder)/$(v).*/bin/python))
PYTHON ?= $(VERSIONS:%=python%) python3 $(pyenv_pythons)
check_python = import ensurepip, sys, venv; "%d.%d" % sys.version_info[:2] in sys.argv or sys.exit(1); print(sys.executable)
find_python = $(shell for p in $(PYTHON); do "$$p" -c '$(check_python)' $(VERSIONS) 2>/dev/null && break; done)

python = $(VENV)/bin/python
# The code that runs is this checkout's, whichever one the environment was made for: tools/environment.py makes the link.
export PYTHONPATH := $(CURDIR)/out/tree

help:
	@echo 'make demo         stripes on a sample mesh: out/demo.blend, out/demo.png, out/demo.json'
	@echo 'make test         the tests, in some minutes'
	@echo 'make test-slow    the other tests'
	@echo 'make fuzz         meshes, settings, files and faults at random; MINUTES=60 SEED=0'
	@echo 'make ui-test      a real Blender window, driven, in English and in German; SYNCH_BLENDER=command starts a Blender, Xvfb has to be there'
	@echo 'make soak         everyday actions at random in that window, without an error on its console; MINUTES=60 SEED=0'
	@echo 'make ui-pictures  the same, and its pictures into docs/'
	@echo 'make lint         ruff (rules and format) and mypy'
	@echo 'make extension    the zip for Blender in out/; WHEELS=1 bundles SciPy, one zip for each platform'
	@echo 'make package      all of a release in out/package: zips of all platforms, a repository of extensions, the wheel of core'
	@echo 'make install-test the release into fresh Blenders: enable, use, disable, uninstall; SYNCH_BLENDER=command for a real one'
	@echo 'make matrix       all tests on each Blender: $(BLENDERS); deprecation warnings are failures'
	@echo 'make docs         the manual as a site in out/site, by MkDocs in an environment of its own; strict: a dead link is an error'
	@echo 'make library      the library of assets that the extension ships; needs Blender 4.5: VENV=.venv-3.11'
	@echo 'make bench        bounds and energies of three meshes beside other methods; MESHES=folder holds them'
	@echo 'make bench-solver times, bounds and energies of six meshes beside other methods, and time against size'
	@echo 'make pictures     the pictures of the README and of docs/; MESHES=folder holds the meshes'
	@echo 'make paper        what is missing of the paper reproduced, docs/paper, in about an hour; MESHES=folder holds the meshes'
	@echo 'make thumbnails   those that the extension ships'
	@echo 'make environment  $(VENV) with Blender as a Python module; the other targets make it on demand'
	@echo 'make clean        remove outputs and caches, keep the environment'
	@echo 'Settings: PYTHON=path/to/python3.13, VENV=folder'

demo: environment
	mkdir -p out
	$(python) -m synch_fields demo

# Runs on several Blenders may share what is the same on all: SHARE=1/2 and SHARE=2/2.
SHARE ?= 1/1

test: environment
	$(python) -m pytest -m 'not slow' --share $(SHARE)

test-slow: environment
	$(python) -m pytest -m slow

MINUTES ?= 10
SEED ?= 0

fuzz: environment
	$(python) tools/fuzz.py $(MINUTES) $(SEED)

# In English, then in German with translated names of new data.
ui-test: environment
	$(python) -m pytest -rs tests/ui --ignore tests/ui/test_soak.py
	SYNCH_LANGUAGE=de_DE $(python) -m pytest -rs tests/ui --ignore tests/ui/test_soak.py --ignore tests/ui/test_languages.py

soak: environment
	SYNCH_SOAK=$(MINUTES) SYNCH_SEED=$(SEED) $(python) -m pytest -rs -s tests/ui/test_soak.py

ui-pictures: ui-test
	cp out/ui/simple.png out/ui/panel.png out/ui/progress.png out/ui/click_2.png out/ui/click_4.png out/ui/click_5.png docs/

lint: environment
	$(python) -m ruff check
	$(python) -m ruff format --check
	$(python) -m mypy core

extension: environment
	$(python) tools/extension.py $(if $(WHEELS),--wheels)

package: environment
	$(python) tools/package.py
	SYNCH_ARCHIVES=out/package/extensions $(python) -m pytest -q tests/addon/test_rules.py

install-test: package $(BLENDERS:%=install-test-%)
	$(if $(SYNCH_BLENDER),$(python) tools/install_test.py out/package/extensions $(SYNCH_BLENDER))

# Nothing but Blender is in these environments.
install-test-%:
	rm -rf out/blender-$*
	$(MAKE) out/blender-$*/bin/python VENV=out/blender-$* VERSIONS=$(call python_of,$*)
	out/blender-$*/bin/python -m pip install --quiet --disable-pip-version-check bpy==$*
	out/blender-$*/bin/python tools/install_test.py out/package/extensions
	rm -rf out/blender-$*

matrix: $(BLENDERS:%=matrix-%)

matrix-%: export PYTEST_ADDOPTS := -W error::DeprecationWarning -W error::PendingDeprecationWarning
matrix-%:
	$(MAKE) test test-slow VENV=.venv-blender-$* BPY=$* VERSIONS=$(call python_of,$*)

docs:
	@test -x .venv-docs/bin/python || $(MAKE) .venv-docs/bin/python VENV=.venv-docs
	@.venv-docs/bin/python tools/environment.py --only docs
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

paper: environment
	$(python) docs/make/paper.py $(MESHES)

thumbnails: environment
	$(python) tools/thumbnails.py

environment:
	@test -x $(python) || $(MAKE) $(python)
	@$(python) tools/environment.py blender test lint $(BPY:%=bpy==%)

$(python):
	$(eval found := $(find_python))
	$(if $(found),,$(error no working Python $(subst $() , or ,$(strip $(VERSIONS))) found: install one or name it with PYTHON=path))
	"$(found)" -m venv $(VENV)

clean:
	rm -rf out build *.egg-info .pytest_cache .ruff_cache .mypy_cache
	find core synch_addon tests bench docs tools -name __pycache__ -prune -exec rm -rf {} +
	rm -rf __pycache__
