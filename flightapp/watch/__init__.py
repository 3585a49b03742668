"""`flightapp watch`: the fleet live in a terminal, on any machine that reaches it.

Three layers: `backend_*` speaks Zenoh; `data_model_*` makes rows, alarms and a map of what was heard, and knows neither network
nor terminal; `frontend_*` shows them.
"""
