"""What is connected: systems, connections, couplings, specifications."""
