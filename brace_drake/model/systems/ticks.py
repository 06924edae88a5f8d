"""When a controller's tick happens among the plant's steps."""

from pydrake.systems.framework import LeafSystem

# A tick comes this much before the plant's step at the same time, s: its
# command then acts from its own tick on, and rounding of event times cannot
# change the order.
TICK_LEAD = 1e-10


def DeclareTick(system: LeafSystem, period: float, update) -> None:
    """Declares a discrete update at time 0 and then at every period.

    Args:
        system: Whose constructor is running.
        period: s.
        update: Callback (context, discrete_values).
    """
    system.DeclareInitializationDiscreteUpdateEvent(update)
    system.DeclarePeriodicDiscreteUpdateEvent(
        period, period - TICK_LEAD, update
    )
