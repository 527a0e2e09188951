/* SPDX-License-Identifier: Apache-2.0
 * BN_ASSERT(condition): states what cannot happen, whatever the arguments, and ends a test that disproves it.
 *
 * Only debug and sanitizer builds of this repository define BN_ASSERTIONS. Others, among them programs that
 * compile libbn without NDEBUG, do not evaluate the condition, because the library never ends a program.
 * Arguments are checked at the public boundary (check.h), not here. */
#ifndef BN_ASSERT_H
#define BN_ASSERT_H

#if defined(BN_ASSERTIONS)
#include <assert.h>
#define BN_ASSERT(condition) assert(condition)
#else
#define BN_ASSERT(condition) ((void)sizeof((condition) ? 1 : 0))
#endif

#endif
