# The commands of this project. `make` alone lists them.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check

# The notebooks run on this environment's kernel and packages, whatever else a person has installed.
export JUPYTER_PREFER_ENV_PATH := 1
export PYTHONNOUSERSITE := 1
unexport PYTHONPATH JUPYTER_PATH PIP_REQUIRE_VIRTUALENV DISTMESH_EDU_STATIC

.DELETE_ON_ERROR:
.PHONY: help book test bench release grade notebooks refresh baseline serve lock clean browser

help:
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST) | expand -t 18

book: $(INSTALLED) ## build the book; its pages are then in _build/html
	$(BIN)/jupyter-book build . -W -n --keep-going
	@$(BIN)/python -m tools.book

test: $(INSTALLED) browser book ## run every check: tests, notebooks, pages, figures, lint, types
	@$(BIN)/python -m tools.check

bench: $(INSTALLED) ## measure how fast it is, and print it
	$(BIN)/python -m benchmarks

release: $(INSTALLED) ## write the students' notebooks anew, and a zip with all that students need
	@$(BIN)/python -m tools.exercises --zip

grade: $(INSTALLED) ## grade what students handed in: make grade SUBMISSIONS=folder-or-zip
	@test -n "$(SUBMISSIONS)" || { echo "Say what to grade: make grade SUBMISSIONS=folder-or-zip"; exit 2; }
	@$(BIN)/python -m tools.grade "$(SUBMISSIONS)" $(if $(OUT),--out "$(OUT)") \
		$(if $(TIMEOUT),--timeout $(TIMEOUT)) $(if $(MEMORY),--memory $(MEMORY))

notebooks: $(INSTALLED) ## open the book's notebooks in JupyterLab
	$(BIN)/jupyter lab $(if $(filter 0,$(shell id -u)),--allow-root) book

refresh: $(INSTALLED) ## execute the committed notebooks afresh, in place, and rebuild the book
	@$(BIN)/python -m tools.refresh
	@$(MAKE) book

baseline: book ## make the figures of this build the ones that the tests compare with
	@$(BIN)/python -m tools.figures

serve: book ## serve the built book on this machine, at http://localhost:8000
	$(BIN)/python -m http.server --bind localhost --directory _build/html 8000

lock: ## choose the exact versions anew (needs uv), and write requirements/lock.txt
	uv pip compile --universal --generate-hashes --fork-strategy fewest --no-annotate --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 --extra book --extra test --extra exercises --extra io \
		--group build --custom-compile-command "make lock" --quiet --output-file requirements/lock.txt pyproject.toml

clean: ## remove what was built; the environment stays
	rm -rf _build build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis

browser: $(INSTALLED)
	@$(BIN)/python -m tools.install_browser

# Installing from a lock with hashes takes exactly the files that the book was checked with.
$(INSTALLED): requirements/lock.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or later is needed. If you have it: make PYTHON=python3.11 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(PIP) install --require-hashes -r requirements/lock.txt
	$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@
