# `make study` and `make test` need Python >= 3.11, make and a package index; nothing needs root but `make system`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CONFIG ?= configs/quick.toml

.PHONY: study test test-all lint types docs docs-serve benchmark constraints system shaders slang clean

study: $(VENV)/.core
	$(BIN)/ecfit run $(CONFIG)

# Two processes of one thread each: most of the time is compilation, which uses one. With the environment of a
# worker (`ecfit.workers.ONE_THREAD`) studies of one table fit in the test's own process.
ONE_THREAD := PJRT_NPROC=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 \
	BLIS_NUM_THREADS=1 VECLIB_MAXIMUM_THREADS=1
PYTEST := $(ONE_THREAD) $(BIN)/pytest -n 2 --dist loadfile
# Most of the time is still LLVM's: without its optimiser and with XLA's older way of fusing, a gradient of the
# dielectric compiles in 4 s of CPU, not 20, and runs as fast on a test's few points. `make test-all` compiles as
# a user does. XLA stops at flags that it does not know: after an update of jaxlib, look here first.
QUICK_COMPILE := XLA_FLAGS="--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false"

test: $(VENV)/.test shaders
	$(QUICK_COMPILE) $(PYTEST)

test-all: $(VENV)/.test $(VENV)/.browser $(VENV)/.docs shaders
	$(PYTEST) -m ""

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# The benchmarks and the engine of clusters are checked too, against what they import.
types: $(VENV)/.dev $(VENV)/.bench $(VENV)/.distributed
	$(BIN)/pyright

# The site, into .site/; every warning is an error. Material's own news is not.
docs: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "docs: .site/index.html"

docs-serve: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs serve

benchmark: $(VENV)/.bench
	$(BIN)/python benchmarks/start.py
	$(BIN)/python benchmarks/tables.py
	$(BIN)/python benchmarks/materials.py
	$(BIN)/python benchmarks/curve_fit.py
	$(BIN)/python benchmarks/thinning.py
	$(BIN)/python benchmarks/evaluation.py
	$(BIN)/python benchmarks/scaling.py
	$(BIN)/python benchmarks/choosing.py --cache .choosing --figures .choosing

constraints: $(VENV)/.uv
	$(BIN)/uv pip compile --universal --no-header --no-annotate --extra test --extra dev --extra bench --extra shaders --extra browser --extra render --extra docs pyproject.toml -o constraints.txt

# System packages for the tests that compile and run shaders, or open a browser; they skip without.
system:
	@.ci/system

# What compiles and runs shaders; where a platform has no such package, its tests are skipped.
shaders: $(VENV)/.shaders $(VENV)/.slang

$(VENV)/.shaders: $(VENV)/.core
	$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt -e '.[shaders]' \
	  && touch $@ || echo "not all of 'ecfit[shaders]' is there for this platform: its tests are skipped"

# The Slang compiler, 34 MB. Alone: what its package depends on is 5.6 GB that nothing here uses.
slang: $(VENV)/.slang

$(VENV)/.slang: $(VENV)/.uv
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps slangtorch==1.3.22 \
	  && touch $@ || echo "no Slang compiler for this platform: its tests are skipped"

$(VENV)/.uv:
	$(PYTHON) -c 'import sys; sys.exit("ecfit needs Python 3.11 or newer: make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	touch $@

$(VENV)/.core: $(VENV)/.uv pyproject.toml constraints.txt
	$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt -e .
	touch $@

$(VENV)/.%: $(VENV)/.core
	$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt -e '.[$*]'
	touch $@

clean:
	rm -rf $(VENV) build dist .site
