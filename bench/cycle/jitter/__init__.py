"""How punctual cycles are: the bus process and a minimal C loop on the same SOEM, in the same conditions."""
