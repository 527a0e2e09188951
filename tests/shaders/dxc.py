# SPDX-License-Identifier: Apache-2.0
"""Compiles HLSL with Microsoft's DXC, a library with COM interfaces: IDxcCompiler3, IDxcResult and IDxcBlob of dxcapi.h."""

import ctypes
import uuid
from ctypes import POINTER, byref, c_int32, c_size_t, c_uint32, c_void_p, c_wchar_p

# Methods of IUnknown. Outside Windows, it also has a virtual destructor, which takes two places.
INHERITED = 5


class _Guid(ctypes.Structure):
    _fields_ = [("data", ctypes.c_ubyte * 16)]

    def __init__(self, text):
        super().__init__((ctypes.c_ubyte * 16)(*uuid.UUID(text).bytes_le))


class _Buffer(ctypes.Structure):
    _fields_ = [("data", ctypes.c_char_p), ("size", c_size_t), ("encoding", c_uint32)]


def _call(this, number, *arguments, types=(), result=c_int32):
    """Calls the method of an object that has this number among its own."""
    table = ctypes.cast(this, POINTER(POINTER(c_void_p)))[0]
    return ctypes.CFUNCTYPE(result, c_void_p, *types)(table[INHERITED + number])(this, *arguments)


def _get(this, number, kind=c_void_p):
    value = kind()
    assert _call(this, number, byref(value), types=(c_void_p,)) == 0
    return value


def _bytes(blob) -> bytes:
    return ctypes.string_at(_call(blob, 0, result=c_void_p), _call(blob, 1, result=c_size_t)) if blob else b""


def compile_hlsl(library, text: str, *arguments: str) -> bytes:
    """Returns DXIL, or with -spirv SPIR-V. The text includes nothing. Raises AssertionError with the compiler's messages."""
    source = text.encode()
    create = ctypes.CDLL(str(library)).DxcCreateInstance
    compiler, result = c_void_p(), c_void_p()
    words = (c_wchar_p * len(arguments))(*arguments)
    assert create(byref(_Guid("73e22d93-e6ce-47f3-b5bf-f0664f39c1b0")), byref(_Guid("228b4687-5a6a-4730-900c-9702b2203f54")),
                  byref(compiler)) == 0
    assert _call(compiler, 0, byref(_Buffer(source, len(source), 65001)), words, len(words), None,
                 byref(_Guid("58346cda-dde7-4497-9461-6f87af5e0659")), byref(result),
                 types=(c_void_p, c_void_p, c_uint32, c_void_p, c_void_p, c_void_p)) == 0
    status, messages = _get(result, 0, c_int32), _bytes(_get(result, 2))
    assert status.value == 0, messages.decode(errors="replace")
    return _bytes(_get(result, 1))
