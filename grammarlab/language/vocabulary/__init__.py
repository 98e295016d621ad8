"""Operations, functions, shape attributes, keywords and types of CGA."""
