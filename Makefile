# Evolutionary fault injection for multi-robot systems. Plain `make` prints the targets.

# Variables for the command line, all optional: make evolve CASE=b SEED=7 WORKERS=4
MISSION ?= uuv_sampling
CASE ?= a
SEED ?=
ENGINE ?=
URL ?=
OUT ?=
RESUME ?=
WORKERS ?=
PYTHON ?=
MARKS ?=

VENV := .venv
BIN := $(VENV)/bin
BASE := $(VENV)/.installed
DEV := $(VENV)/.installed-dev
DOCS := $(VENV)/.installed-docs
INTEROP := $(VENV)/.installed-interop
SETUP := pyproject.toml constraints.txt
PREBUILT := src/mrsfi_runtime/engine/compiled/prebuilt
PYTEST := $(BIN)/python -m pytest --numprocesses auto --durations 10
QUICK := tests/disk tests/golden tests/model tests/property tests/unit
OURS := --dist worksteal --ignore=tests/interop --ignore=tests/release

# Their values are data: make does not expand them, and the shell gets them quoted.
VARIABLES := MISSION CASE SEED ENGINE URL OUT RESUME WORKERS PYTHON
$(foreach name,$(VARIABLES),$(eval override $(name) := $$(value $(name))))
quoted = '$(subst ','\'',$(1))'

mission = $(call quoted,$(or $(MISSION),uuv_sampling))
pythons = $(if $(PYTHON),$(call quoted,$(PYTHON)),python3 python3.13 python3.12 python3.11)
seed = $(if $(SEED),--seed $(call quoted,$(SEED)))
workers = $(if $(WORKERS),--workers $(call quoted,$(WORKERS)))
engine = $(if $(ENGINE),--engine $(call quoted,$(ENGINE))) $(if $(URL),--url $(call quoted,$(URL)))
out = $(if $(OUT),--out $(call quoted,$(OUT)))
new = $(mission) --case $(call quoted,$(or $(CASE),a)) $(seed) $(out)
campaign = $(if $(RESUME),--resume $(call quoted,$(RESUME)),$(new))

# Pinned twice: for what is installed, and for the isolated environment that builds the package.
export PIP_CONSTRAINT := constraints.txt
export PIP_BUILD_CONSTRAINT := constraints.txt
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help install code generate validate simulate evolve report regressions quick test test-all test-night interop wheel release check site clean

help: ## print this list
	@echo "Targets:"
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile
	@echo
	@printf '%s\n' $(call quoted,Variables: $(foreach name,$(VARIABLES),$(name)=$($(name))))
	@echo "           CASE is a, b or a campaign file; ENGINE is auto, compiled, reference or rosbridge,"
	@echo "           the last with the server at URL, or one that it starts; OUT is a campaign folder;"
	@echo "           RESUME is an interrupted one to continue. Empty leaves the default."
	@echo "Example:   make evolve CASE=b SEED=7"

install: $(BASE) ## make the virtual environment .venv, install mrsfi into it and compile its kernel
	@echo "Compiling the simulation kernel, unless this was done before: about 25 seconds."
	@$(BIN)/python -m mrsfi_runtime.engine.compiled

code: $(BASE)
	$(BIN)/mrsfi generate $(mission)

generate: code ## generate the middleware of MISSION, and the classes for scripts that make models
	$(BIN)/python -m m2t.classes generated/metamodel

validate: $(BASE) ## check the models of MISSION
	$(BIN)/mrsfi validate $(mission)

simulate: code ## fly MISSION once without faults
	$(BIN)/mrsfi simulate $(mission) $(seed) $(engine)

evolve: code ## search for faults that break the goals of MISSION, and print its weaknesses
	$(BIN)/mrsfi evolve $(campaign) $(engine) $(workers)

report: $(BASE) ## write the report of campaign folder OUT again (default: the latest of runs/)
	$(BIN)/mrsfi report $(if $(OUT),$(call quoted,$(OUT)))

regressions: code ## fly the kept weaknesses of MISSION; fails if one exceeds its limit
	$(BIN)/mrsfi check $(mission) $(engine)

quick: $(DEV) ## run the units and laws of the tests, in about a minute
	$(PYTEST) --dist worksteal --hypothesis-profile quick $(QUICK)

test: $(DEV) generate ## run the tests, in some minutes
	$(PYTEST) $(OURS)

test-all: $(DEV) generate ## run the slow tests that are not left to the night: kills, more seeds
	$(PYTEST) $(OURS) -m "slow and not night"

test-night: $(DEV) generate ## run every test, with all seeds, then make interop and make release
	$(PYTEST) $(OURS) -m "" --hypothesis-profile night
	$(MAKE) interop release

interop: $(INTEROP) generate ## compare with the real Eclipse, Epsilon, roslibpy, roslib, MuJoCo, ir-sim, pymunk, pfta, reqif, Chromium, pdfLaTeX, LibreOffice
	$(PYTEST) --dist loadfile --no-loadscope-reorder -m "$(MARKS)" tests/interop

wheel: $(DEV) ## build sdist and wheel into dist/, in a minute
	rm -rf build dist
	$(BIN)/python -m build --sdist --outdir dist .
	mkdir build && tar --extract --file dist/*.tar.gz --directory build --strip-components 1
	PYTHONPATH=build/src $(BIN)/python -m mrsfi_runtime.engine.compiled build/$(PREBUILT)
	$(BIN)/python -m build --wheel --outdir dist build
	rm -rf build

release: wheel ## make wheel, and run the tutorial from the wheel in clean environments
	$(BIN)/python -m twine check --strict dist/*
	$(PYTEST) -m "$(MARKS)" tests/release

check: $(DEV) ## check formatting, lint, types, imports and that generated code is fresh
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	@for models in models/*/; do \
	  echo "$(BIN)/mrsfi generate $$models --check"; \
	  $(BIN)/mrsfi generate "$$models" --check || exit $$?; \
	done
	$(BIN)/python -m m2t.classes generated/metamodel --check

site: $(DOCS) ## build the documentation as a site into site/; a broken link is an error
	$(BIN)/mkdocs build

clean: ## remove .venv, caches and build products; campaigns in runs/ stay
	rm -rf $(VENV) build dist site .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	rm -rf tests/interop/java/target
	find . -path ./runs -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

$(BASE): $(SETUP) | $(VENV)/.created
	@echo "Installing mrsfi and its packages into $(VENV): about a minute."
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[fast]"
	@touch $@

$(DEV): $(SETUP) | $(VENV)/.created
	@echo "Installing mrsfi, its packages and the tools of its tests: about two minutes."
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[dev,fast]"
	@touch $(BASE) $@

$(DOCS): $(BASE)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[docs]"
	@touch $@

$(INTEROP): $(DEV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[browser,examples,interop]"
	@touch $@

$(VENV)/.created:
	@python=; set -- $(pythons); \
	for candidate; do \
	  if "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; \
	  then python="$$candidate"; break; fi; \
	done; \
	if [ -z "$$python" ]; then \
	  echo "mrsfi needs Python 3.11 or newer, and found none among: $$*." >&2; \
	  echo "Install one, or name it: make evolve PYTHON=/path/to/python3.11" >&2; \
	  exit 1; \
	fi; \
	echo "Making the virtual environment $(VENV) with $$("$$python" --version): some seconds."; \
	"$$python" -m venv $(VENV) || { \
	  echo "'$$python -m venv' failed; on Debian and Ubuntu install python3-venv." >&2; exit 1; }
	@touch $@
