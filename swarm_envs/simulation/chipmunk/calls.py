"""Chipmunk's C functions, called from compiled code through their addresses.

Addresses travel as integers in an array, so that the compiled code holds no pointer of one process and numba can cache it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import cfunc, types
from numba.extending import intrinsic
from pymunk._chipmunk_cffi import ffi, lib

from swarm_envs.compiled import cache_folder, caching_in

# Entries of a world's row of handles.
STEP, EACH_BODY, MOVE_BODY, GET_BATCH, SET_BATCH, SET_BIAS, SPACE, GET_DATA, SET_DATA, BODIES = range(10)


def function_addresses() -> npt.NDArray[np.int64]:
    """Return the addresses (6,) of the functions that the compiled loop calls, in the order of the constants above."""
    names = [
        "cpSpaceStep",
        "cpSpaceEachBody",
        "cpBodyUpdatePosition",
        "pmSpaceBodyGetIteratorFuncBatched",
        "pmSpaceBodySetIteratorFuncBatched",
        "cpSpaceSetCollisionBias",
    ]
    return np.array([address(ffi.addressof(lib, name)) for name in names], np.int64)


def address(pointer: Any) -> int:
    """Return a cffi pointer as a number."""
    return int(ffi.cast("intptr_t", pointer))


with caching_in(cache_folder()):

    @cfunc(types.void(types.voidptr, types.double), cache=True)
    def keep_still(body: Any, duration: float) -> None:
        """Position function that moves nothing: see :mod:`swarm_envs.simulation.chipmunk` for who moves the bodies."""


def _call(builder: ir.IRBuilder, at: ir.Value, arguments: list[ir.Value]) -> None:
    kind = ir.FunctionType(ir.VoidType(), [argument.type for argument in arguments])
    builder.call(builder.inttoptr(at, kind.as_pointer()), arguments)


@intrinsic
def call_with_double(typing_context: Any, function: Any, pointer: Any, number: Any) -> Any:
    """Call ``void f(void *, double)`` at an address: ``call_with_double(function, pointer, number)``."""

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        at, first, second = arguments
        _call(builder, at, [builder.inttoptr(first, ir.IntType(8).as_pointer()), second])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.float64), generate


@intrinsic
def call_with_pointers(typing_context: Any, function: Any, first: Any, second: Any, third: Any) -> Any:
    """Call ``void f(void *, void *, void *)`` at an address: ``call_with_pointers(function, first, second, third)``."""

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        at, *pointers = arguments
        _call(builder, at, [builder.inttoptr(pointer, ir.IntType(8).as_pointer()) for pointer in pointers])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, types.int64), generate
