"""Talk to hardware; imports nothing of the other packages."""
