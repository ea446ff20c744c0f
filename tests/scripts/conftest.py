# SPDX-License-Identifier: MIT
"""Scripts are no package: the tests load each from its file."""

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

PYPROJECT = """
[project]
name = "probe"
version = "1"
[tool.pytest.ini_options]
markers = ["real_data", "long"]
[tool.mypy]
files = ["probe.py"]
[tool.ruff]
exclude = ["scripts"]
"""
SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"scripts_{name}", SCRIPTS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def load_beside(*names: str) -> ModuleType:
    """Load scripts in this order, each as the later ones find it beside themselves; return the last."""
    for name in names:
        sys.modules[name] = load(name)
    return sys.modules[names[-1]]


@pytest.fixture(scope="session")
def environment():
    return load_beside("environment")


@pytest.fixture(scope="session")
def blenders(environment):
    return load_beside("wheels", "blenders")


@pytest.fixture(scope="session")
def build_extension(blenders):
    return load_beside("build_extension")


@pytest.fixture(scope="session")
def test(build_extension):
    return load("test")


@pytest.fixture(scope="session")
def demo(blenders):
    return load("demo")


@pytest.fixture
def project(tmp_path, environment):
    """Return a repository of its own whose `.venv` is ready, but without pip: to install must fail."""
    root = tmp_path.resolve()
    (root / "scripts").mkdir()
    for name in ("environment.py", "test.py", "blenders.py", "wheels.py", "build_extension.py"):
        (root / "scripts" / name).write_bytes((SCRIPTS / name).read_bytes())
    (root / "pyproject.toml").write_text(PYPROJECT)
    environment.run("Making it", [sys.executable, "-m", "venv", "--without-pip", str(root / ".venv")])
    stamp = json.dumps(environment.wanted_stamp(root, ["benchmark", "demo", "test"]))
    (root / ".venv" / environment.STAMP_NAME).write_text(stamp)
    return root
