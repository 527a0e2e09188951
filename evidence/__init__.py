# SPDX-License-Identifier: Apache-2.0
"""Measures the samplers: the benches, their results, and the pages made from the results. Run by scripts/bench."""
