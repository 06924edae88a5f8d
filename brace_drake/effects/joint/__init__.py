"""Laws of one joint alone, whatever machine it is of."""
