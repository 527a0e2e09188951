# SPDX-License-Identifier: Apache-2.0
"""FLIP: the difference between two pictures as seen when one alternates between them.

The mean of HDR-FLIP (Andersson, Nilsson, Shirley and Akenine-Moller, "Visualizing Errors in Rendered High Dynamic
Range Images", 2021), as the package flip-evaluator computes it, on linear radiance: the exposures it looks at
follow from the reference alone, and no tone curve of ours comes in. 0 is no difference, 1 the greatest. Its defaults
stand for a screen of 0.7 m, 3840 pixels wide, seen from 0.7 m.
"""

import os
import threading

import numpy as np

# Pictures are small and many: its threads would mostly wait for each other. Set before the library starts them.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# Nothing says that two calls may run at once.
_LOCK = threading.Lock()


class FlipMissing(Exception):
    """The message says what to install."""


def mean_flip(image, reference):
    try:
        import flip_evaluator
    except ImportError:
        raise FlipMissing("the package flip-evaluator is missing; install it with scripts/setup, or with "
                          "pip install flip-evaluator") from None
    image, reference = (np.ascontiguousarray(np.maximum(picture, 0), np.float32) for picture in (image, reference))
    if image.shape != reference.shape:
        raise ValueError(f"image {image.shape} and reference {reference.shape} differ in shape")
    with _LOCK:
        # The parameters are a dict that the call fills in: a fresh one each time, or the first reference's stay.
        return float(flip_evaluator.evaluate(reference, image, "HDR", applyMagma=False, parameters={})[1])
