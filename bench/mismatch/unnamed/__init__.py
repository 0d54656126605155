"""What is left when all that can be predicted has been: tests of its mean and of its variance, and what they find."""
