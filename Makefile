# All set-up happens here: `make demo` and `make test` work on a fresh clone with git, python3 (3.11 or newer) and make.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.ready

.PHONY: demo test lint format bench accuracy tried reproduce docs lock clean

demo: $(STAMP)
	$(BIN)/bematist demo -o demo

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadfile

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(STAMP)
	$(BIN)/python benchmarks/run.py

# docs/accuracy.md: every recording at hand, by every method; the tables in docs/attitude.md, docs/hand.md, docs/map.md, docs/pdr.md and docs/hard-iron.md
accuracy: $(STAMP)
	$(BIN)/python benchmarks/accuracy.py
	$(BIN)/python benchmarks/attitude.py
	$(BIN)/python benchmarks/waypoints.py
	$(BIN)/python benchmarks/hard_iron.py

# the tables of what was tried in docs/stance.md and docs/hand.md
tried: $(STAMP)
	$(BIN)/python benchmarks/tried.py
	$(BIN)/python benchmarks/hand_tried.py

# docs/reproduce: tables and figures of the papers; what was computed is kept in build/reproduce, and only what is missing is computed
reproduce: $(STAMP)
	for paper in maginav li-wang magyq; do \
	  $(BIN)/bematist reproduce $$paper -o build/reproduce/$$paper && mkdir -p docs/reproduce/$$paper && \
	  cp -r build/reproduce/$$paper/report.md build/reproduce/$$paper/figures build/reproduce/$$paper/tables docs/reproduce/$$paper/ && \
	  rm -f docs/reproduce/$$paper/figures/*.svg docs/reproduce/$$paper/tables/*-cases.csv docs/reproduce/$$paper/tables/*.md || exit 1; \
	done

# docs/parameters.md
docs: $(STAMP)
	$(BIN)/python benchmarks/parameters_page.py

$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "bematist needs Python 3.11 or newer: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	$(BIN)/python -m bematist.warmup
	touch $(STAMP)

# Write requirements.lock anew from pyproject.toml (needs uv)
lock:
	uv pip compile --universal --python-version 3.11 --group dev pyproject.toml -o requirements.lock --no-header --quiet

clean:
	rm -rf .venv demo dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
