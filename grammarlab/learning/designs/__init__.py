"""What can be liked: designs that can be named, made again and described by numbers."""
