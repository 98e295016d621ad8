"""What scenario and rule files say about features: scores and acceptance."""
