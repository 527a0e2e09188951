# SPDX-License-Identifier: Apache-2.0
"""FLIP: the perceived difference between two pictures when alternating between them.

The mean of HDR-FLIP (Andersson, Nilsson, Shirley and Akenine-Moller, "Visualizing Errors in Rendered High Dynamic
Range Images", 2021), computed by the package flip-evaluator on linear radiance: its exposures depend on the reference
alone, and none of our tone curves is involved. 0 is no difference, 1 the largest. The defaults model a screen 0.7 m and
3840 pixels wide, seen from 0.7 m.
"""

import os
import threading

import numpy as np

from ..base.command import package

# With many small pictures its threads would mostly wait for each other. Must be set before the library starts them.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# The package does not document thread safety.
_LOCK = threading.Lock()


def mean_flip(image, reference):
    flip_evaluator = package("flip_evaluator", "scripts/setup or pip install flip-evaluator")
    image, reference = (np.ascontiguousarray(np.maximum(picture, 0), np.float32) for picture in (image, reference))
    if image.shape != reference.shape:
        raise ValueError(f"image {image.shape} and reference {reference.shape} differ in shape")
    with _LOCK:
        # The call fills in `parameters`, so pass a new dict each time; otherwise those of the first reference persist.
        return float(flip_evaluator.evaluate(reference, image, "HDR", applyMagma=False, parameters={})[1])
