# SPDX-License-Identifier: Apache-2.0
"""The search finds minima. Training reduces the error, resumes exactly and reports mistakes on one line."""

import csv
import math
import resource
import shutil
import sys

import pytest
import torch
from bn_trainer.__main__ import main
from bn_trainer.config import Config, load
from bn_trainer.evolution import Evolution
from bn_trainer.files import load_checkpoint
from bn_trainer.train import LOG_COLUMNS, Trainer, noise

TINY = """
[model]
reaches = [2, 4, 2]
channels = 1
[loss]
sigmas = [1.0, 1.5]
shares = [0.5, 0.5]
energy = 0.0
[train]
iterations = 24
seed = 7
size = 16
batch = 1
population = 6
step = 1.0
log_every = 4
check_every = 8
"""


def tiny(tmp_path, name="tiny.toml", **changes):
    """Writes a small configuration with changed lines, and returns its path."""
    text = TINY
    for key, value in changes.items():
        lines = [f"{key} = {value}" if line.split(" = ")[0] == key else line for line in text.splitlines()]
        assert lines != text.splitlines()
        text = "\n".join(lines)
    path = tmp_path / name
    path.write_text(text)
    return path


def run(config, folder, *more):
    """Trains without output, from a configuration or, if `config` is None, from the folder alone."""
    start = [] if config is None else ["--config", str(config)]
    return main(["train", *start, "--folder", str(folder), "--threads", "1", "--quiet", *more])


def refuse(capsys, arguments, *words):
    """Runs a command that must fail and print a single line containing these words."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 1, arguments
    error = capsys.readouterr().err
    assert error.startswith("bn_trainer: ") and error.count("\n") == 1 and all(word in error for word in words), (arguments, error)


def log_of(folder):
    """The rows of the log, without the column of seconds."""
    with open(folder / "log.csv", newline="") as file:
        return [row[:-1] for row in csv.reader(file)]


def states_equal(a, b):
    if isinstance(a, torch.Tensor):
        return torch.equal(a, b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(states_equal(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(states_equal(x, y) for x, y in zip(a, b))
    return a == b


TARGET = torch.linspace(-3, 3, 8, dtype=torch.float64)


def search_of(n=8, **changes):
    options = {"population": 12, "step": 1.0, "seed": 5, **changes}
    return Evolution(torch.ones(n), torch.full((n,), 0.5), **options)


@pytest.mark.parametrize("population", [12, 13])
def test_search_learns_correlated_directions(population):
    """Minimises a rotated quadratic that is a million times as steep in some directions as in others."""
    turn = torch.linalg.qr(torch.randn(8, 8, dtype=torch.float64, generator=torch.Generator().manual_seed(1)))[0]
    steepness = torch.logspace(0, 6, 8, dtype=torch.float64)
    search = search_of(population=population)
    for _ in range(450):
        search.learn(((search.candidates() - TARGET) @ turn).square() @ steepness)
    assert float((search.mean - TARGET).abs().max()) < 1e-3


def test_search_tolerates_noise():
    search, generator = search_of(population=40), torch.Generator().manual_seed(2)
    for _ in range(150):
        losses = (search.candidates() - TARGET).square().sum(1)
        search.learn(losses + 0.1 * torch.randn(40, dtype=torch.float64, generator=generator))
    # An error of .1 in every parameter changes the loss by about as much as the noise does.
    assert float((search.mean - TARGET).square().mean()) < 0.1**2


def test_restored_search_continues_identically():
    search, other = search_of(), search_of(step=0.2)
    for _ in range(5):
        search.learn((search.candidates() - TARGET).square().sum(1))
    other.restore(search.state())
    for _ in range(3):
        candidates = search.candidates()
        assert torch.equal(candidates, other.candidates())
        for each in (search, other):
            each.learn((candidates - TARGET).square().sum(1))
    assert states_equal(search.state(), other.state())
    # Different generations and seeds produce different candidates.
    start, other = search_of(), search_of()
    assert not torch.equal(start.candidates(), search_of(seed=6).candidates())
    other.generation = 1
    assert not torch.equal(start.candidates(), other.candidates())
    with pytest.raises(ValueError, match="mean"):
        search_of(n=7).restore(search.state())


@pytest.mark.parametrize("channels", [1, 2])
def test_training_reduces_the_error(tmp_path, channels):
    changes = {"channels": 2, "energy": 1.0} if channels == 2 else {}
    path = tiny(tmp_path, reaches="[2, 4]", size=24, population=12, **changes)
    trainer = Trainer(load(path, Config), torch.device("cpu"))
    # Starting with very soft signs leaves much to learn.
    with torch.no_grad():
        for step in trainer.model.steps:
            step.sharpness.fill_(-1.5)
    trainer.search.mean = trainer.model.vector()
    before = trainer.measure()
    for _ in range(25):
        trainer.step()
    after = trainer.measure()
    assert trainer.iteration == 25
    assert after[0] < 0.9 * before[0] and after[1] < 0.9 * before[1]
    if channels == 2:
        assert after[2] < before[2] - 0.004
    else:
        assert math.isnan(before[2]) and math.isnan(after[2])


def test_loss_follows_the_configuration(tmp_path):
    batch = noise(1, 2, (2, 1, 16, 16))

    def loss(**changes):
        trainer = Trainer(load(tiny(tmp_path, channels=2, **changes), Config), torch.device("cpu"))
        return trainer.figures(trainer.search.mean, batch)

    whole, e1, e15, energy = loss(shares="[0.25, 3.0]", energy=0.5)
    assert whole == pytest.approx(0.25 * e1**2 + 3 * e15**2 + 0.5 * energy, rel=1e-6)
    assert 0 < e15 < e1 < 0.2 and 0.5 < energy < 0.62
    assert loss(sigmas="[1.5]", shares="[1.0]")[0] == pytest.approx(e15**2, rel=1e-6)


def test_resume_is_exact(tmp_path):
    path = tiny(tmp_path)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run(path, whole) == 0
    # Resuming from the checkpoint of iteration 8 after a stop at 13 rewrites the log's later rows.
    assert run(path, parts, "--stop-after", "8") == 0
    shutil.copy(parts / "checkpoint.pt", tmp_path / "kept.pt")
    assert run(None, parts, "--resume", "--stop-after", "13") == 0
    assert [row[0] for row in log_of(parts)] == ["iteration", "4", "8", "12", "13"]
    shutil.copy(tmp_path / "kept.pt", parts / "checkpoint.pt")
    kept = (parts / "log.csv").read_text().splitlines()[:3]
    assert run(None, parts, "--resume") == 0
    first, second = load_checkpoint(whole / "checkpoint.pt"), load_checkpoint(parts / "checkpoint.pt")
    assert first["search"]["generation"] == second["search"]["generation"] == 24
    assert states_equal(first, second)
    assert log_of(parts) == log_of(whole)
    assert [row[0] for row in log_of(whole)] == ["iteration", "4", "8", "12", "16", "20", "24"]
    assert log_of(whole)[0] == LOG_COLUMNS[:-1]
    assert (parts / "log.csv").read_text().splitlines()[:3] == kept
    assert load(whole / "config.toml", Config) == load(path, Config)
    assert not [f for f in whole.iterdir() if f.name.startswith(".")]
    # Resuming a finished run changes nothing.
    assert run(None, parts, "--resume") == 0 and log_of(parts) == log_of(whole)


def test_resume_with_another_configuration_names_the_difference(tmp_path, capsys):
    path, folder = tiny(tmp_path), tmp_path / "run"
    assert run(path, folder, "--stop-after", "4") == 0
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    other = tiny(tmp_path, "other.toml", iterations=40, sigmas="[1.0, 2.0]")
    refuse(capsys, ["train", "--resume", "--config", other, "--folder", folder],
           "loss.sigmas is [1.0, 1.5], not [1.0, 2.0], train.iterations is 24, not 40; leave out --config")
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    assert run(path, folder, "--resume") == 0 and log_of(folder)[-1][0] == "24"  # the same configuration is no error


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on file sizes")
def test_full_disk_is_one_line_and_keeps_the_checkpoint(tmp_path, capsys):
    """A file size limit of 1 KiB stands for a full disk."""
    path, folder = tiny(tmp_path), tmp_path / "run"
    assert run(path, folder, "--stop-after", "8") == 0
    before, limits = (folder / "checkpoint.pt").read_bytes(), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1024, limits[1]))
    try:
        refuse(capsys, ["train", "--resume", "--folder", folder, "--threads", "1", "--quiet"],
               f"cannot write {folder / 'checkpoint.pt'}: File too large")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (folder / "checkpoint.pt").read_bytes() == before
    assert run(None, folder, "--resume") == 0 and log_of(folder)[-1][0] == "24"


def test_noise_depends_only_on_seed_and_iteration():
    assert torch.equal(noise(3, 8, (2, 5)), noise(3, 8, (2, 5)))
    assert not torch.equal(noise(3, 8, (2, 5)), noise(3, 9, (2, 5)))
    assert not torch.equal(noise(3, 8, (2, 5)), noise(4, 8, (2, 5)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reaches": "[]"}, "model.reaches: List should have at least 1 item"),
        ({"reaches": "[4, 0]"}, "model.reaches.1: Input should be greater than or equal to 1, not 0"),
        ({"channels": "3"}, "model.channels: Input should be 1 or 2, not 3"),
        ({"channels": "2\nkernels = [5]"}, "model.kernels: Extra inputs are not permitted"),
        ({"sigmas": "[0.1, 1.0]"}, "loss.sigmas.0: Input should be greater than or equal to 0.25"),
        ({"sigmas": "[inf, 1.0]"}, "loss.sigmas.0: Input should be a finite number"),
        ({"shares": "[1.0]"}, "loss.shares must be as long as loss.sigmas"),
        ({"energy": "1.0"}, "loss.energy needs model.channels = 2"),
        ({"batch": "true"}, "train.batch: Input should be a valid integer, not True"),
        ({"population": "3"}, "train.population must be 0 or at least 4"),
        ({"step": "0.0"}, "train.step: Input should be greater than 0"),
        ({"check_every": "8 ="}, "is not valid TOML"),
    ],
)
def test_invalid_configurations_fail_with_one_line(tmp_path, capsys, changes, message):
    path = tiny(tmp_path, **changes)
    refuse(capsys, ["train", "--config", path, "--folder", tmp_path / "run"], message, "tiny.toml")
    assert not (tmp_path / "run").exists()


def test_bad_checkpoints_fail_with_one_line(tmp_path, capsys):
    path = tiny(tmp_path, iterations=1)
    assert run(path, tmp_path / "run") == 0
    good = load_checkpoint(tmp_path / "run" / "checkpoint.pt")
    longer = {**good, "config": {**good["config"], "model": {"reaches": [2, 4, 2, 2], "channels": 1}}}
    hostile = {**good, "config": {**good["config"], "model": {"reaches": [], "channels": 1}}}
    damaged = (tmp_path / "run" / "checkpoint.pt").read_bytes()[:1000]
    for name, checkpoint, message in (
        ("damaged", damaged, "not a checkpoint, or is damaged"),
        ("foreign", {"weights": torch.ones(3)}, "not a checkpoint of this trainer"),
        ("tensor", torch.ones(3), "not a checkpoint of this trainer"),
        ("old", {**good, "format": "bn_trainer 1"}, "not a checkpoint of this trainer"),
        ("empty", {"format": good["format"]}, "not a checkpoint of this trainer"),
        ("longer", longer, ("does not match its configuration", "do not fit the model in its configuration")),
        ("no search", {**good, "search": {}}, ("does not match its configuration", "do not fit")),
        ("hostile", hostile, "model.reaches: List should have at least 1 item"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        file = folder / "checkpoint.pt"
        file.write_bytes(checkpoint) if isinstance(checkpoint, bytes) else torch.save(checkpoint, file)
        resumed, exported = (message, message) if isinstance(message, str) else message
        refuse(capsys, ["train", "--resume", "--folder", folder], resumed)
        refuse(capsys, ["export", file, "-o", tmp_path / "x.onnx"], exported)
        assert [f.name for f in folder.iterdir()] == ["checkpoint.pt"]
    assert not (tmp_path / "x.onnx").exists()


def test_other_errors_print_one_line(tmp_path, capsys):
    path = tiny(tmp_path, iterations=1)
    folder = tmp_path / "run"
    assert run(path, folder) == 0
    (tmp_path / "file").write_text("")
    for arguments, message in (
        (["train", "--config", tmp_path / "none.toml"], "cannot read the configuration"),
        (["train"], "give a configuration"),
        (["train", "--config", path, "--folder", folder], "already contains a run"),
        (["train", "--resume", "--folder", tmp_path / "nothing"], "contains no checkpoint"),
        (["train", "--config", path, "--folder", tmp_path / "file" / "run"], "file"),
        (["export", tmp_path / "none.pt", "-o", tmp_path / "x.onnx"], "cannot read the checkpoint"),
        (["evaluate", tmp_path / "none.onnx"], "cannot read"),
        (["evaluate", path], "not a checkpoint, or is damaged"),
    ):
        refuse(capsys, arguments, message)
    assert not (tmp_path / "x.onnx").exists()
