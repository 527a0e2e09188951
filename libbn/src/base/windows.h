/* SPDX-License-Identifier: Apache-2.0
 * The functions of Windows that base/ calls, declared as in <windows.h>. That header would define macros such
 * as far and min for every file compiled together with libbn. Files may include it before or after this one. */
#ifndef BN_WINDOWS_H
#define BN_WINDOWS_H

#include <stddef.h>

struct _RTL_SRWLOCK;
struct _RTL_CONDITION_VARIABLE;
struct _SECURITY_ATTRIBUTES;

#if defined(_WIN64)
typedef unsigned long long bn_windows_word;
#else
typedef unsigned long bn_windows_word;
#endif

#define BN_WINDOWS __declspec(dllimport)
BN_WINDOWS void __stdcall AcquireSRWLockExclusive(struct _RTL_SRWLOCK *);
BN_WINDOWS void __stdcall ReleaseSRWLockExclusive(struct _RTL_SRWLOCK *);
BN_WINDOWS int __stdcall SleepConditionVariableSRW(struct _RTL_CONDITION_VARIABLE *,
                                                   struct _RTL_SRWLOCK *, unsigned long,
                                                   unsigned long);
BN_WINDOWS void __stdcall WakeAllConditionVariable(struct _RTL_CONDITION_VARIABLE *);
BN_WINDOWS void *__stdcall CreateThread(struct _SECURITY_ATTRIBUTES *, bn_windows_word,
                                        unsigned long(__stdcall *)(void *), void *, unsigned long,
                                        unsigned long *);
BN_WINDOWS unsigned long __stdcall WaitForSingleObject(void *, unsigned long);
BN_WINDOWS int __stdcall CloseHandle(void *);
BN_WINDOWS void *__stdcall GetCurrentProcess(void);
BN_WINDOWS int __stdcall GetProcessAffinityMask(void *, bn_windows_word *, bn_windows_word *);
#undef BN_WINDOWS

#endif
