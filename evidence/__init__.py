# SPDX-License-Identifier: Apache-2.0
"""Measures the samplers: how, what came out (results), and pages made from it. scripts/bench runs it."""
