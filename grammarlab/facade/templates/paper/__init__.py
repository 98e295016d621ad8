"""The loop of paper 001, chapter 5: deformation, common subspace, labelling and similarities, until labels stay."""
