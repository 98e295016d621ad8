"""Who does the tasks of a run: processes and executors."""
