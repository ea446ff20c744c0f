# SPDX-License-Identifier: MIT
"""Files for farms: they are read as their programs read them, and use options that there are."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core.cli.parser import build_parser

ROOT = Path(__file__).resolve().parents[2]
FARM = ROOT / "packaging" / "farm"

COMPILE = """
const fs = require("fs"), tasks = [];
const author = {
    Task: (name, type) => ({name, type, commands: [], addCommand(command) { this.commands.push(command); }}),
    Command: (name, parameters) => ({name, parameters}),
};
const [script, given] = process.argv.slice(1);
const load = new Function("author", fs.readFileSync(script, "utf8") + "; return [JOB_TYPE, compileJob];");
const [type, compile] = load(author);
const defaults = Object.fromEntries(type.settings.map(setting => [setting.key, setting.default]));
compile({settings: {...defaults, ...JSON.parse(given)}, addTask: task => tasks.push(task)});
console.log(JSON.stringify(tasks));
"""


def check_arguments(words: list[str]) -> dict[str, Any]:
    """Read the arguments of a command as it does itself."""
    return vars(build_parser().parse_args(words))


def tasks_of(**settings: object) -> list[list[str]]:
    """Command lines that the job type of Flamenco makes."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no Node.js")
    command = [node, "-e", COMPILE, str(FARM / "shape-google.js"), json.dumps(settings)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    made = [command["parameters"] for task in json.loads(output) for command in task["commands"]]
    return [[parameters["exe"], *parameters["args"]] for parameters in made]


def test_each_task_of_flamenco_indexes_its_part(tmp_path: Path) -> None:
    made = tasks_of(folder="/mnt/my assets", parts=3)
    for part, command in enumerate(made, start=1):
        assert command[:4] == ["sh", "-c", 'shapegoogle index "$@" || [ $? -eq 1 ]', "sh"]
        options = check_arguments(["index", *command[4:]])
        assert [str(path) for path in options["inputs"]] == ["/mnt/my assets"]
        assert (options["shard"].number, options["shard"].count) == (part, 3)
    assert len(made) == 3
    # What another worker could not read either is no failure; everything else is.
    for code, expected in ((0, 0), (1, 0), (2, 2), (130, 130)):
        script = tmp_path / f"{code}.py"
        script.write_text(f"#!/bin/sh\nexit {code}\n")
        script.chmod(0o755)
        (command,) = tasks_of(folder=".", parts=1, program=str(script))
        assert (subprocess.run(command, check=False).returncode == 0) == (expected == 0)


def test_the_script_of_slurm_is_one_of_bash_and_passes_failures_on(tmp_path: Path) -> None:
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    # What srun would run, in place of it.
    (tmp_path / "srun").write_text('#!/bin/sh\necho "$@"\nexit "$CODE"\n')
    (tmp_path / "srun").chmod(0o755)
    slurm = {"SLURM_ARRAY_TASK_ID": "3", "SLURM_ARRAY_TASK_MAX": "16", "SLURM_CPUS_PER_TASK": "8"}
    for code, expected in (("0", 0), ("1", 0), ("2", 2)):
        done = subprocess.run(
            ["bash", str(FARM / "slurm.sh"), "/mnt/assets", "postgresql://farm@server/shapes"],
            env={**slurm, "CODE": code, "PATH": f"{tmp_path}:/usr/bin:/bin"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == expected, done.stderr
        program, *words = shlex.split(done.stdout)
        options = check_arguments(words)
        assert (program, options["shard"].number, options["jobs"]) == ("shapegoogle", 3, 8)


def test_the_job_of_kubernetes_indexes_one_part_in_each_pod() -> None:
    yaml = pytest.importorskip("yaml")
    job = yaml.safe_load((FARM / "kubernetes.yaml").read_text(encoding="utf-8"))
    (container,) = job["spec"]["template"]["spec"]["containers"]
    (line,) = container["args"]
    line = line.replace("$((JOB_COMPLETION_INDEX + 1))", "16").partition("||")[0]
    program, *words = shlex.split(line)
    options = check_arguments(words)
    assert (program, job["spec"]["completionMode"]) == ("shapegoogle", "Indexed")
    assert options["shard"].number == options["shard"].count == job["spec"]["completions"]
    assert container["volumeMounts"][0]["name"] == job["spec"]["template"]["spec"]["volumes"][0]["name"]


def test_the_container_has_what_the_package_is_made_of() -> None:
    recipe = (FARM / "Containerfile").read_text(encoding="utf-8")
    for copied in re.findall(r"^COPY (.+) \S+$", recipe, re.MULTILINE):
        assert all((ROOT / name).exists() for name in copied.split())
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    (extras,) = re.findall(r'"\.\[(.+)\]"', recipe)
    assert all(f"\n{extra} = [" in project for extra in extras.split(","))


def test_the_configuration_of_dask_is_one() -> None:
    yaml = pytest.importorskip("yaml")
    page = (ROOT / "docs" / "howto" / "farm.md").read_text(encoding="utf-8")
    written = yaml.safe_load(page.partition("```yaml\n")[2].partition("```")[0])["distributed"]
    config = pytest.importorskip("dask.config")
    pytest.importorskip("distributed")
    known = config.get("distributed")
    assert written["comm"].keys() <= known["comm"].keys()
    assert written["comm"]["tls"].keys() <= known["comm"]["tls"].keys()
    assert written["worker"].keys() <= known["worker"].keys()
