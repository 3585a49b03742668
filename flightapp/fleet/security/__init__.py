"""Who may join the fleet and who may say what: certificates, and Zenoh's access rules made from them."""
