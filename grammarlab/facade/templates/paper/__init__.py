"""The loop of paper 001, chapter 5: deformation, common subspace, labelling, similarities, until labels are stable."""
