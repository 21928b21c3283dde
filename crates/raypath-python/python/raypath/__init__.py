"""An open hardware ray-tracer datapath: its models, generator, renderer and vector search."""
