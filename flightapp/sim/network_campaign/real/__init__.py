"""Real vehicle processes on real Zenoh over a shaped network: in network namespaces where possible, else through a proxy."""
