# SPDX-License-Identifier: Apache-2.0
"""Renders, measures and reports: what scripts/demo is made of, and what benchmarks share with it."""
