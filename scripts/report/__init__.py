# SPDX-License-Identifier: Apache-2.0
"""Rendering, measuring and reporting for scripts/demo and scripts/bench."""
