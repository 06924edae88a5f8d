"""A machine watched beside its twin: since when they differ, and why.

`noise_model` whitens their difference, `usual` takes off what was there from
the beginning, `detector` says since when it is more than noise, `watch` puts
these together sample by sample. `causes` tries every effect of the library as
if it had begun then, by the search that a diagnosis makes. Nothing here knows
of a device: numbers in, numbers out.
"""
