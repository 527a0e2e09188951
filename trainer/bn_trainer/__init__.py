# SPDX-License-Identifier: Apache-2.0
"""Training, evaluation and export of the network that turns white noise into blue-noise masks."""
