"""One call from a request to files and a picture on disk."""
