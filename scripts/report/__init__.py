# SPDX-License-Identifier: Apache-2.0
"""Rendering, measuring and reporting for scripts/demo, scripts/convergence and scripts/bench."""
