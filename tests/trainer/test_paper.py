# SPDX-License-Identifier: Apache-2.0
"""The paper's losses and perceptron, Wronski's method, and the table that compares the methods."""


import numpy as np
import pytest
import torch
from bn_trainer.__main__ import main
from bn_trainer.config import TrainerError, load
from bn_trainer.paper import perceptron as paper
from bn_trainer.paper import pictures, table, wronski
from PIL import Image

import bluenoise

TINY = paper.PaperConfig(size=8, hidden=20, batch=16, inputs=160, epochs=8, rate=5e-3, seed=3)


def test_spectrum_matches_the_fft():
    for size in (2, 5, 8):
        masks = torch.from_numpy(np.random.default_rng(1).random((2, size, size), dtype=np.float32))
        assert torch.allclose(paper.spectrum(masks), torch.fft.fft2(masks).abs(), atol=1e-4)


def test_low_frequency_weights_by_hand():
    # The coordinates are 1, 1/3, -1/3 and -1. Only the four inner points lie inside; they are frequencies 0 and -1.
    expected = torch.zeros(4, 4)
    expected[::3, ::3] = ((0.7 - 2 / 9) / 0.7) ** 2
    assert torch.allclose(paper.low_frequency_weights(4), expected, atol=1e-6)


def test_blue_spectrum_loss_by_hand():
    wave = torch.cos(torch.arange(4) * torch.pi / 2).expand(1, 4, 4)  # amplitude 8 at (0, 1) and (0, -1)
    loss = paper.blue_spectrum_loss(paper.spectrum(wave), paper.low_frequency_weights(4))
    assert loss.item() == pytest.approx(((0.7 - 2 / 9) / 0.7) ** 2 * 64 / 16, rel=1e-5)


def test_uniform_spectrum_loss_by_hand():
    spike = torch.zeros(1, 4, 4)
    spike[0, 2, 1] = 1
    laplacian, differences = (16 + 4) / 25, 4 / 4
    assert paper.uniform_spectrum_loss(spike).item() == pytest.approx((laplacian + differences) / 16)
    assert paper.uniform_spectrum_loss(torch.ones(1, 4, 4)).item() == 0


def test_histogram_loss_by_hand():
    masks = torch.tensor([[[0.5, -0.2], [0.9, -1.0]]], requires_grad=True)  # sorted against -1, -1/3, 1/3, 1
    squares = 0 + (1 / 3 - 0.2) ** 2 + (0.5 - 1 / 3) ** 2 + 0.1**2
    assert paper.histogram_loss(masks, "sum").item() == pytest.approx(squares, rel=1e-5)
    loss = paper.histogram_loss(masks, "mean")
    assert loss.item() == pytest.approx(squares / 4, rel=1e-5)
    loss.backward()
    assert torch.allclose(masks.grad[0], torch.tensor([[0.5 - 1 / 3, 1 / 3 - 0.2], [-0.1, 0]]) * 2 / 4, atol=1e-6)


def test_white_noise_depends_only_on_seed_and_index():
    many = paper.white_noise(16, 5, range(100))
    assert torch.equal(many[40:42], paper.white_noise(16, 5, [40, 41]))
    assert not torch.equal(many[40], paper.white_noise(16, 6, [40])[0])
    assert many.min() >= -1 and many.max() < 1
    assert abs(many.mean()) < 5 * (1 / 3 / many.numel()) ** 0.5  # five deviations: the false-alarm rate is below 1e-6


def test_training_lowers_the_loss(tmp_path):
    before, _ = paper.paper_loss(torch.from_numpy(paper.generate(paper.PaperTraining(TINY).model, range(32), 8)), TINY,
                                 paper.low_frequency_weights(8))
    run = paper.train(TINY, tmp_path / "run")
    after, terms = paper.paper_loss(torch.from_numpy(paper.generate(run.model, range(32), 8)), TINY,
                                    paper.low_frequency_weights(8))
    assert run.iteration == TINY.iterations == 80
    assert after < 0.6 * before
    again = paper.PaperTraining.load(tmp_path / "run" / "checkpoint.pt")
    assert np.array_equal(paper.generate(again.model, [5], 8), paper.generate(run.model, [5], 8))


def test_foreign_checkpoints_are_rejected(tmp_path):
    (tmp_path / "checkpoint.pt").write_bytes(b"something else")
    with pytest.raises(TrainerError, match="another --folder"):
        paper.train(TINY, tmp_path)
    with pytest.raises(TrainerError, match="not a checkpoint"):
        paper.PaperTraining.load(tmp_path / "checkpoint.pt")


def test_configs(tmp_path, request):
    for path in sorted((request.config.rootpath / "trainer" / "configs").glob("paper-*.toml")):
        config = load(path, paper.PaperConfig)
        assert f"paper-{config.size}" + ("-sum" if config.histogram == "sum" else "") == path.stem
        assert config.iterations == 6000
    bad = tmp_path / "bad.toml"
    bad.write_text("size = 64\nlearning_rate = 1\n")
    with pytest.raises(TrainerError, match="learning_rate"):
        load(bad, paper.PaperConfig)
    bad.write_text('histogram = "max"\n')
    with pytest.raises(TrainerError, match="histogram: Input should be 'mean' or 'sum'"):
        load(bad, paper.PaperConfig)


def test_wronski_lowers_the_dithering_error():
    losses = []
    masks = wronski.optimise(32, [0, 1, 2], 200, progress=losses.append)
    assert losses[-1] < 0.2 * losses[0]
    assert masks.shape == (3, 32, 32)
    for mask in masks:  # white noise has 0.115 with a standard deviation of 0.004 at this size
        assert bluenoise.dithering_error(mask) < 0.09
        assert abs(mask.std() - 3**-0.5) < 0.02


def test_wronski_masks_do_not_depend_on_each_other():
    together = wronski.optimise(16, [4, 5], 10)
    assert np.allclose(together[1], wronski.optimise(16, [5], 10)[0], atol=1e-4)


def test_threshold_error_matches_the_library():
    ranks = bluenoise.mask((32, 32), seed=1)
    values = table.ranks_of(ranks[None].astype(np.float32))[0]
    for sigma in (1, 1.5):
        assert table.threshold_error(values, sigma) == pytest.approx(bluenoise.dithering_error(ranks, sigma), rel=1e-3)


def test_dithering_error_of_a_grey_image_by_hand():
    grey = np.full((pictures.PICTURE_SIZE,) * 2, 0.5, np.float32)
    chequer = np.float32([[[0.25, 0.75], [0.75, 0.25]]])  # a texel is white where 0.5 + threshold >= 1
    assert pictures.dithering_errors(chequer, grey, [0.01])[0, 0] == pytest.approx(0.5)
    assert pictures.dithering_errors(chequer, grey, [3.0])[0, 0] < 1e-3


def test_input_images(tmp_path):
    for picture in pictures.synthetic_pictures().values():
        assert picture.shape == (256, 256) and picture.dtype == np.float32
        assert picture.min() >= 0 and picture.max() <= 1
    path = tmp_path / "grey.png"
    Image.new("L", (300, 260), 51).save(path)
    name, part = pictures.read_picture(f"{path}@40,4")
    assert name == "grey" and part.shape == (256, 256) and np.allclose(part, 0.2)
    for argument in (f"{path}@50,4", f"{path}@x", str(tmp_path / "none.png")):
        with pytest.raises(TrainerError, match="picture"):
            pictures.read_picture(argument)


def test_table_command(tmp_path, capsys):
    config = paper.PaperConfig(size=16, hidden=10, batch=8, inputs=80, epochs=2)
    paper.train(config, tmp_path / "paper-16")
    out = tmp_path / "report"
    out.mkdir()
    marks = "<!-- table: {} -->\n\nold\n\n<!-- end of the table -->\n"
    (out / "paper.md").write_text("".join(map(marks.format, ("errors", "masks", "descent"))))
    assert main(["table", "--runs", str(tmp_path), "--sizes", "16", "--masks", "3", "--wronski-masks", "2",
                 "--wronski-iterations", "30", "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["paper.md", "paper.png"]
    text = (out / "paper.md").read_text()
    printed = capsys.readouterr().out
    assert "old" not in text and all(line in printed for line in text.splitlines() if not line.startswith("<!--"))
    for name in ("white noise", "perceptron", "perceptron, ranks made exact", "Wronski", "void-and-cluster"):
        assert text.count(f"| 16x16 {name} |") == 2
    assert "20 of 20 iterations" in printed
    with Image.open(out / "paper.png") as sheet:
        assert sheet.width > 100
