# SPDX-License-Identifier: Apache-2.0
"""Reproduction of Giunchi, Sztrajman and Steed, "Fast blue-noise generation via unsupervised learning" (IJCNN 2022)."""
