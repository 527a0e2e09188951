# SPDX-License-Identifier: Apache-2.0
"""MkDocs extensions for scripts/docs: pages generated from the headers, and the repository's files in their original folders."""
