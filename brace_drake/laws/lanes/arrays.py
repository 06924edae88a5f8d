"""Arrays of lanes: arrays of floats with the copies along the last axis."""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj

from brace_drake.laws.lanes.kinds import COUNT, LANES, index, join_lanes


def stack_copies(copies):
    """What each copy has, as one: arrays of floats (...) become arrays of all
    copies (..., COUNT), in tuples too. The last copy is repeated where there
    are fewer; what else there is, is that of the first.
    """
    first = copies[0]
    if isinstance(first, tuple):
        parts = [stack_copies(part) for part in zip(*copies, strict=True)]
        named = hasattr(first, "_fields")
        return type(first)(*parts) if named else tuple(parts)
    if not isinstance(first, np.ndarray) or first.dtype != float:
        return first
    filled = [*copies, *[copies[-1]] * (COUNT - len(copies))]
    return np.ascontiguousarray(np.stack(filled, axis=-1))


def in_one_piece(stacked):
    """The same arrays of all copies, as parts of one (numbers, COUNT) that
    holds them one behind the other; and that one.
    """
    arrays: list[np.ndarray] = []
    _visit(stacked, arrays.append)
    whole = np.concatenate([a.reshape((-1, COUNT)) for a in arrays])
    ends = np.cumsum([a.size // COUNT for a in arrays])
    parts = iter(np.split(whole, ends[:-1]))
    return _replaced(stacked, parts), whole


def put_copy(stacked, copy, place: int) -> None:
    """Writes what a copy has into its place in what `stack_copies` made."""
    if isinstance(copy, tuple):
        for part, own in zip(stacked, copy, strict=True):
            put_copy(part, own, place)
    elif isinstance(copy, np.ndarray) and copy.dtype == float:
        stacked[..., place] = copy


def _visit(stacked, take) -> None:
    if isinstance(stacked, tuple):
        for part in stacked:
            _visit(part, take)
    elif isinstance(stacked, np.ndarray) and stacked.dtype == float:
        take(stacked)


def _replaced(stacked, parts):
    """The same, with its arrays of floats taken from flat parts in turn."""
    if isinstance(stacked, tuple):
        found = [_replaced(part, parts) for part in stacked]
        named = hasattr(stacked, "_fields")
        return type(stacked)(*found) if named else tuple(found)
    if isinstance(stacked, np.ndarray) and stacked.dtype == float:
        return next(parts).reshape(stacked.shape)
    return stacked


def _mapped(kind, change):
    """A kind of tuple, or of array, with its arrays of floats changed."""
    if isinstance(kind, types.BaseTuple):
        parts = [_mapped(part, change) for part in kind.types]
        if isinstance(kind, types.NamedTuple | types.NamedUniTuple):
            return types.NamedTuple(parts, kind.instance_class)
        return types.Tuple(parts)
    is_floats = isinstance(kind, types.Array) and kind.dtype == types.float64
    return change(kind) if is_floats else kind


def stacked_kind(kind):
    """Kind of what `stack_copies` makes of copies of a kind."""
    return _mapped(kind, lambda k: types.Array(types.float64, k.ndim + 1, "C"))


def _lane_kind(kind):
    # Floats need not lie where a vector would.
    return types.Array(LANES, kind.ndim - 1, "C", aligned=False)


# Kind of a vector of lanes.
LANE_VECTOR = _lane_kind(types.Array(types.float64, 2, "C"))


def _look_at(context, builder, kind, value, out):
    """An array's data looked at as another kind: with a dimension less, or one
    more, or a vector of floats as one of lanes.
    """
    source = arrayobj.make_array(kind)(context, builder, value)
    shape = cgutils.unpack_tuple(builder, source.shape)
    strides = cgutils.unpack_tuple(builder, source.strides)
    size = 8 * COUNT if out.dtype == LANES else 8
    if out.ndim < kind.ndim:
        shape, strides = shape[:-1], strides[:-1]
    elif out.ndim == kind.ndim:
        count = context.get_constant(types.intp, COUNT)
        shape = [builder.sdiv(shape[0], count)]
        strides = [context.get_constant(types.intp, size)]
    else:
        shape = [*shape, context.get_constant(types.intp, COUNT)]
        strides = [*strides, context.get_constant(types.intp, size)]
    item = context.get_data_type(out.dtype)
    array = arrayobj.make_array(out)(context, builder)
    arrayobj.populate_array(
        array,
        data=builder.bitcast(source.data, item.as_pointer()),
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=context.get_constant(types.intp, size),
        # Who looks does not own the data.
        meminfo=None,
        parent=None,
    )
    return array._getvalue()


def _convert(context, builder, kind, value):
    """Arrays of floats of a value, in tuples too, looked at as lanes."""
    if isinstance(kind, types.BaseTuple):
        out = _mapped(kind, _lane_kind)
        struct = context.get_constant_undef(out)
        for place, part in enumerate(kind.types):
            item = builder.extract_value(value, place)
            item = _convert(context, builder, part, item)
            struct = builder.insert_value(struct, item, place)
        return struct
    out = _mapped(kind, _lane_kind)
    if out == kind:
        # Handed on, so owned once more.
        if context.enable_nrt:
            context.nrt.incref(builder, kind, value)
        return value
    return _look_at(context, builder, kind, value, out)


@intrinsic
def lanes_of(typingctx, stacked):
    """What `stack_copies` made, which must live on, looked at as lanes."""

    def convert(context, builder, sig, args):
        return _convert(context, builder, sig.args[0], args[0])

    return _mapped(stacked, _lane_kind)(stacked), convert


@intrinsic
def lanes_in(typingctx, floats):
    """A vector of floats (m COUNT,), the copies of each number behind each
    other, looked at as lanes (m,).
    """

    def look(context, builder, sig, args):
        return _look_at(context, builder, sig.args[0], args[0], LANE_VECTOR)

    return LANE_VECTOR(floats), look


@intrinsic
def pick(typingctx, values, place):
    """values[place] of a whole number that copies may differ in, given as a
    float; it must be a place of theirs.
    """

    def load(context, builder, sig, args):
        array = arrayobj.make_array(sig.args[0])(context, builder, args[0])
        floats = builder.bitcast(array.data, ir.DoubleType().as_pointer())
        if sig.return_type != LANES:
            at = builder.fptosi(args[1], ir.IntType(64))
            return builder.load(builder.gep(floats, [at]))
        whole = ir.VectorType(ir.IntType(64), COUNT)
        places = builder.fptosi(args[1], whole)
        found = []
        for copy in range(COUNT):
            at = builder.extract_element(places, index(copy))
            at = builder.mul(at, ir.Constant(at.type, COUNT))
            at = builder.add(at, ir.Constant(at.type, copy))
            found.append(builder.load(builder.gep(floats, [at])))
        return join_lanes(builder, found)

    return values.dtype(values, values.dtype), load


@intrinsic
def floats_of(typingctx, lanes):
    """Lanes (...), looked at as floats (..., COUNT)."""
    kind = types.Array(types.float64, lanes.ndim + 1, "C")

    def look(context, builder, sig, args):
        return _look_at(context, builder, sig.args[0], args[0], kind)

    return kind(lanes), look
