"""From blocks to a labelled dataset: verdicts, boundaries measured and predicted, another criterion, finer edges."""
