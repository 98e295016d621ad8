"""Pages of this machine: who is served, how windows talk, and what a request is."""
