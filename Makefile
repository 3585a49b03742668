# Two commands: `make run` flies the demo, `make test` checks everything. Both build the virtual environment they need.
# `make run RUN=folder` says where its recordings go; with FLIGHTAPP_FLOWN_DEMO=folder in the environment the tests judge that flight.
VENV := .venv
PY := $(VENV)/bin/python
MISSION := missions/demo_two_pursuers.toml
IN_REAL_TIME := tests/runtime tests/scenarios/test_interruptions.py
CROWDED := tests/scenarios/test_demo_mission.py tests/scenarios/test_whole_fleets.py

.PHONY: run test lint types pytest install-nuc clean
run: $(VENV)/.ok
	$(PY) -m flightapp sim $(MISSION) $(if $(RUN),--run '$(RUN)')

test: lint types pytest

lint: $(VENV)/.ok
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

types: $(VENV)/.ok
	$(PY) -m mypy

# What flies in real time is not disturbed by what only computes; whole fleets fly alone.
pytest: $(VENV)/.ok
	$(PY) -m pytest -n 2 --dist loadfile $(addprefix --ignore=,$(IN_REAL_TIME) $(CROWDED)) --durations=10 tests
	$(PY) -c 'import flightapp.runtime.vehicle_process'
	$(PY) -m pytest -n 2 --dist worksteal --durations=10 $(IN_REAL_TIME)
	$(PY) -m pytest --durations=10 $(CROWDED)

# On the companion computer, as root: program, systemd unit, udev rules. Options stand in tools/deploy/install.sh.
install-nuc:
	DESTDIR='$(DESTDIR)' PROGRAM='$(PROGRAM)' PIXHAWK_SERIAL='$(PIXHAWK_SERIAL)' tools/deploy/install.sh

# pip compiles on one core; compileall does the same on all of them.
$(VENV)/.ok: pyproject.toml requirements.txt
	python3 -m venv $(VENV)
	PIP_CONSTRAINT=requirements.txt $(PY) -m pip install --quiet --disable-pip-version-check --no-compile -e '.[dev,realsense]'
	$(PY) -m compileall -qq -j 0 $(VENV)/lib
	$(PY) -m flightapp.warm_up
	touch $@

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .hypothesis
