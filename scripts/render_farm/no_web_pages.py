# SPDX-License-Identifier: Apache-2.0
"""Loaded by the scheduler and the workers of a cluster on this machine, whose web servers it closes."""


def dask_setup(server):
    server.http_server.stop()
