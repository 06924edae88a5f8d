"""The brace in Drake: the reference that the compiled laws are held to.

`brace_station.MakeBraceStation` builds the diagram of one to three stages
around a controller, `MakeControlledBrace` around the scenario's own;
`simulate.RecordBrace` runs it and returns a recording. `brace_plant` has the
bodies, `articulated` the legs as bodies, `systems` the laws as LeafSystems.
"""
