# SPDX-License-Identifier: Apache-2.0
"""Renders one image on the workers of a Dask cluster; see scripts/farm --help."""
