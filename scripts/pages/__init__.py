# SPDX-License-Identifier: Apache-2.0
"""What scripts/docs adds to MkDocs: pages from the headers, and the files of the repository where they are."""
