"""Six linear equations, those of a stage, without allocation."""

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.functions import some, where


@compiled_law
def _exchange_rows(A, b, i, r, better):
    """Exchanges rows i and r, of those copies where that is better."""
    for c in range(i, 6):
        upper, lower = A[i, c], A[r, c]
        A[i, c] = where(better, lower, upper)
        A[r, c] = where(better, upper, lower)
    upper, lower = b[i], b[r]
    b[i], b[r] = where(better, lower, upper), where(better, upper, lower)


@compiled_law
def solve_in_place(A, b):
    """Solves A x = b by elimination; x replaces b.

    A row takes another's place where its pivot is more than twice as large:
    what is alike by symmetry stays where it is.

    Args:
        A: Matrix (6, 6), destroyed.
        b: Right-hand side (6,), replaced by the solution.

    Returns:
        False where A, of any copy, is singular to working precision.
    """
    # Known to the compiler, which makes it three times as fast.
    n = 6
    for i in range(n):
        for r in range(i + 1, n):
            better = abs(A[r, i]) > 2.0 * abs(A[i, i])
            if some(better):
                _exchange_rows(A, b, i, r, better)
        if some(abs(A[i, i]) < 1e-14):
            return False
        inverse = 1.0 / A[i, i]
        for r in range(i + 1, n):
            factor = A[r, i] * inverse
            for c in range(i + 1, n):
                A[r, c] -= factor * A[i, c]
            b[r] -= factor * b[i]
    for i in range(n - 1, -1, -1):
        total = b[i]
        for c in range(i + 1, n):
            total -= A[i, c] * b[c]
        b[i] = total / A[i, i]
    return True
