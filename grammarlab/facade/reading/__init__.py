"""Files in which others keep facades: each reader makes an `Annotation` of the content of a file."""
