"""./run check: starts somebody's launch file and tells what came up."""
