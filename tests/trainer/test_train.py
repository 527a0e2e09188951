# SPDX-License-Identifier: Apache-2.0
"""Training: it learns, resumes exactly, runs in several processes, and reports mistakes in one line."""

import csv
import subprocess
import sys

import pytest
import torch

from bn_trainer.__main__ import main
from bn_trainer.files import load_checkpoint
from bn_trainer.train import Trainer, noise
from bn_trainer import config as configs

TINY = """
[model]
channels = [4, 4, 4]
kernels = [5, 5, 5]
sigma = 0.85
first_rate = {first_rate}
last_rate = 0.5
[loss]
sigmas = [1.0]
shares = [1.0]
inner_steps = 1
tail = 1
[train]
iterations = {iterations}
seed = 7
size = 32
batch = 2
rate = 5e-3
last_rate = 1e-3
warmup = 5
average = 0.9
log_every = 4
check_every = 8
"""


def tiny(tmp_path, name="tiny.toml", iterations=24, first_rate=2.0, **changes):
    text = TINY.format(iterations=iterations, first_rate=first_rate)
    for key, value in changes.items():
        lines = [f"{key} = {value}" if line.split(" = ")[0] == key else line for line in text.splitlines()]
        assert lines != text.splitlines()
        text = "\n".join(lines)
    path = tmp_path / name
    path.write_text(text)
    return path


def states_equal(a, b):
    if isinstance(a, torch.Tensor):
        return torch.equal(a, b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(states_equal(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(states_equal(x, y) for x, y in zip(a, b))
    return a == b


def test_the_error_falls(tmp_path):
    # Steps far too small to start from leave much to learn.
    path = tiny(tmp_path, iterations=40, first_rate=0.6)
    trainer = Trainer(configs.load(path), torch.device("cpu"))
    before = trainer.measure()
    for _ in range(40):
        trainer.step()
    after = trainer.measure()
    assert after[0] < 0.95 * before[0]


def test_resume_is_exact(tmp_path):
    path = tiny(tmp_path)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert main(["train", "--config", str(path), "--folder", str(whole), "--threads", "1", "--quiet"]) == 0
    # Stopped between checkpoints: what the log holds beyond the last one is written again.
    assert main(["train", "--config", str(path), "--folder", str(parts), "--threads", "1", "--quiet", "--stop-after", "13"]) == 0
    rows = list(csv.reader(open(parts / "log.csv")))
    with open(parts / "log.csv", "a") as file:
        file.write("14,9,9,9,9,9\n")
    assert main(["train", "--folder", str(parts), "--resume", "--threads", "1", "--quiet"]) == 0
    first, second = load_checkpoint(whole / "checkpoint.pt"), load_checkpoint(parts / "checkpoint.pt")
    assert first["iteration"] == second["iteration"] == 24
    assert states_equal(first, second)
    assert states_equal(load_checkpoint(whole / "best.pt"), load_checkpoint(parts / "best.pt"))
    again = list(csv.reader(open(parts / "log.csv")))
    assert again[: len(rows)] == rows
    assert [row[0] for row in again] == ["iteration", "4", "8", "12", "13", "16", "20", "24"]
    assert configs.load(whole / "config.toml") == configs.load(path)
    assert not [f for f in whole.iterdir() if f.name.startswith(".")]


def test_noise_depends_on_seed_and_iteration_alone():
    assert torch.equal(noise(3, 8, (2, 5)), noise(3, 8, (2, 5)))
    assert not torch.equal(noise(3, 8, (2, 5)), noise(3, 9, (2, 5)))
    assert not torch.equal(noise(3, 8, (2, 5)), noise(4, 8, (2, 5)))


def test_two_processes_train_as_one(tmp_path, trainer_environment):
    path = tiny(tmp_path, iterations=6)
    alone, shared = tmp_path / "alone", tmp_path / "shared"
    assert main(["train", "--config", str(path), "--folder", str(alone), "--threads", "1", "--quiet"]) == 0
    # As torchrun --standalone, but by address: names may not be resolved on a bare system, and torch then waits long.
    here = "127.0.0.1"
    done = subprocess.run(
        [sys.executable, "-m", "torch.distributed.run", "--nnodes", "1", "--nproc-per-node", "2", "--rdzv-backend", "c10d",
         "--rdzv-endpoint", f"{here}:0", "--local-addr", here, "-m", "bn_trainer", "train",
         "--config", str(path), "--folder", str(shared), "--threads", "1", "--quiet"],
        env={**trainer_environment, "GLOO_SOCKET_IFNAME": "lo"}, cwd=tmp_path, capture_output=True, text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    first, second = load_checkpoint(alone / "checkpoint.pt"), load_checkpoint(shared / "checkpoint.pt")
    assert first["iteration"] == second["iteration"] == 6
    for name, value in first["model"].items():
        # Sums in another order; Adam turns differences of tiny gradients into steps.
        assert torch.allclose(value, second["model"][name], atol=2e-3), name
    assert len(list(csv.reader(open(shared / "log.csv")))) == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"channels": "[]"}, "model.channels must name 1 to 64 steps"),
        ({"kernels": "[5, 4, 5]"}, "model.kernels must be odd"),
        ({"kernels": "[5, 5]"}, "as long as model.channels"),
        ({"sigma": "nan"}, "model.sigma must be of type float"),
        ({"sigma": '"big"'}, "model.sigma must be of type float"),
        ({"shares": "[-1.0]"}, "loss.shares must be positive"),
        ({"iterations": "0"}, "train.iterations must be 1 to"),
        ({"batch": "true"}, "train.batch must be of type int"),
        ({"size": "8"}, "train.size must be 16 to 4096"),
        ({"rate": "1e-3\nspeed = 3"}, "the keys of [train] are iterations"),
        ({"tail": "1\n[extra]"}, "the tables of a configuration are model, loss, train"),
        ({"tail": "1 ="}, "is not valid TOML"),
    ],
)
def test_hostile_configurations(tmp_path, capsys, changes, message):
    path = tiny(tmp_path, **changes)
    assert main(["train", "--config", str(path), "--folder", str(tmp_path / "run")]) == 1
    error = capsys.readouterr().err
    assert error.startswith("bn_trainer: ") and error.count("\n") == 1 and message in error and "tiny.toml" in error
    assert not (tmp_path / "run").exists()


def test_other_mistakes_are_one_line(tmp_path, capsys):
    path = tiny(tmp_path, iterations=1)
    run = tmp_path / "run"
    bad = tmp_path / "bad.pt"
    bad.write_bytes(b"no checkpoint")
    assert main(["train", "--config", str(path), "--folder", str(run), "--quiet"]) == 0
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "checkpoint.pt").write_bytes((run / "checkpoint.pt").read_bytes()[:1000])
    (tmp_path / "file").write_text("")
    capsys.readouterr()
    for arguments, message in (
        (["train", "--config", str(tmp_path / "none.toml")], "cannot read the configuration"),
        (["train"], "give a configuration"),
        (["train", "--config", str(path), "--folder", str(run)], "already contains a run"),
        (["train", "--resume", "--folder", str(tmp_path / "nothing")], "contains no checkpoint"),
        (["train", "--resume", "--folder", str(tmp_path / "broken")], "not a checkpoint, or is damaged"),
        (["train", "--config", str(path), "--folder", str(tmp_path / "file" / "run")], "file"),
        (["export", str(bad), "-o", str(tmp_path / "x.onnx")], "not a checkpoint, or is damaged"),
        (["export", str(tmp_path / "none.pt"), "-o", str(tmp_path / "x.onnx")], "cannot read the checkpoint"),
        (["evaluate", str(tmp_path / "none.onnx")], "cannot read"),
    ):
        assert main(arguments) == 1, arguments
        error = capsys.readouterr().err
        assert error.startswith("bn_trainer: ") and error.count("\n") == 1 and message in error, error
    assert not (tmp_path / "x.onnx").exists()
