"""Six linear equations, those of a stage, without allocation."""

from brace_drake.laws.compiled import compiled_law


@compiled_law
def solve_in_place(A, b):
    """Solves A x = b by elimination with row pivots; x replaces b.

    Args:
        A: Matrix (6, 6), destroyed.
        b: Right-hand side (6,), replaced by the solution.

    Returns:
        False where A is singular to working precision.
    """
    # Known to the compiler, which makes it three times as fast.
    n = 6
    for i in range(n):
        pivot = i
        largest = abs(A[i, i])
        for r in range(i + 1, n):
            if abs(A[r, i]) > largest:
                largest = abs(A[r, i])
                pivot = r
        if largest < 1e-14:
            return False
        if pivot != i:
            for c in range(i, n):
                A[i, c], A[pivot, c] = A[pivot, c], A[i, c]
            b[i], b[pivot] = b[pivot], b[i]
        inverse = 1.0 / A[i, i]
        for r in range(i + 1, n):
            factor = A[r, i] * inverse
            if factor != 0.0:
                for c in range(i + 1, n):
                    A[r, c] -= factor * A[i, c]
                b[r] -= factor * b[i]
    for i in range(n - 1, -1, -1):
        total = b[i]
        for c in range(i + 1, n):
            total -= A[i, c] * b[c]
        b[i] = total / A[i, i]
    return True
