// SPDX-License-Identifier: Apache-2.0
// A bound for the memory of this process, so that a scene made to waste it ends in one line and not
// with the machine's.
#pragma once

// Half of the machine's memory in GiB, or 0 if the system does not say.
double memory_default();

// From here on, allocations beyond this many GiB fail, those of libraries and threads too; 0 is no
// bound. Works on Linux from 4.7 on; elsewhere some systems do without.
void memory_limit(double gib);
