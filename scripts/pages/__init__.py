# SPDX-License-Identifier: Apache-2.0
"""Extensions of MkDocs for scripts/docs: pages made from the headers, and the repository's files in their own folders."""
